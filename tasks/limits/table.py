"""A table of allowable deviations, with what one must know before believing it."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from storage.errors import InputError, ShapeError
from tasks.geometry.failure import FitFailure


class LimitKind(StrEnum):
    """What a limit was written for; a deviation should be judged by one of its own kind."""

    CONSTRUCTION = "construction"
    DESIGN = "design"
    IN_SERVICE = "in-service"
    MEASUREMENT = "measurement"
    UNSTATED = "unstated"


@dataclass(frozen=True, slots=True)
class LimitPoint:
    """The allowable deviation at one height."""

    height_m: float
    allowable_m: float


@dataclass(frozen=True, slots=True)
class PointsRule:
    """Linear between the given heights; no limit outside them."""

    points: tuple[LimitPoint, ...]

    @property
    def described(self) -> str:
        """The rule in words."""
        points = ", ".join(f"{point.allowable_m:g} m at {point.height_m:g} m" for point in self.points)
        return f"{points}; linear between"

    @property
    def holds(self) -> str:
        """The heights it holds for, in words."""
        return f"from {self.points[0].height_m:g} m to {self.points[-1].height_m:g} m"

    def allowable_m(self, height_m: float) -> float | FitFailure:
        """Allowable deviation at a height, metres, or why there is none."""
        if not self.points[0].height_m <= height_m <= self.points[-1].height_m:
            return FitFailure(f"the table holds {self.holds}; the height is {height_m:g} m")
        heights = [point.height_m for point in self.points]
        return float(np.interp(height_m, heights, [point.allowable_m for point in self.points]))


@dataclass(frozen=True, slots=True)
class RatioRule:
    """A share of the height: not less than ``least_m``, not more than ``largest_m``, where there are such.

    It holds above ``above_m`` and, where that is not None, up to ``up_to_m``.
    """

    ratio: float
    above_m: float
    largest_m: float | None
    least_m: float | None = None
    up_to_m: float | None = None

    @property
    def described(self) -> str:
        """The rule in words."""
        share = f"height/{1.0 / self.ratio:g}"
        if self.least_m is not None:
            share = f"max({share}, {self.least_m:g} m)"
        if self.largest_m is not None:
            share = f"min({share}, {self.largest_m:g} m)"
        return share

    @property
    def holds(self) -> str:
        """The heights it holds for, in words."""
        to = "" if self.up_to_m is None else f" up to {self.up_to_m:g} m"
        return f"above {self.above_m:g} m{to}"

    def allowable_m(self, height_m: float) -> float | FitFailure:
        """Allowable deviation at a height, metres, or why there is none."""
        if height_m <= self.above_m or (self.up_to_m is not None and height_m > self.up_to_m):
            return FitFailure(f"the rule holds {self.holds}; the height is {height_m:g} m")
        share = self.ratio * height_m
        share = share if self.least_m is None else max(share, self.least_m)
        return share if self.largest_m is None else min(share, self.largest_m)


@dataclass(frozen=True, slots=True)
class LimitTable:
    """A rule and its papers.

    ``version`` counts the changes of the data here; ``verified_by`` names who compared them with the
    document itself, None where nobody has. ``valid_from`` is the date (ISO 8601) from which epochs are judged by this
    version, None where it holds for all. A limit of kind measurement bounds so many ``sigmas`` of the deviation, not the
    deviation.
    """

    name: str
    version: int
    rule: PointsRule | RatioRule
    kind: LimitKind
    document: str
    edition: str
    clause: str
    source: str
    verified_by: str | None
    note: str
    valid_from: str | None = None
    sigmas: float = 1.0

    @property
    def described(self) -> str:
        """Name, kind and standing of the limit, for the reason of a verdict."""
        article = "an" if self.kind is LimitKind.IN_SERVICE else "a"
        kind = (
            "a limit of unstated kind" if self.kind is LimitKind.UNSTATED else f"{article} {self.kind} limit"
        )
        standing = (
            f"verified by {self.verified_by}" if self.verified_by else "not verified against the document"
        )
        return f"{self.name}, {kind}, {standing}"


@dataclass(frozen=True, slots=True)
class MissingLimit:
    """A limit that the campaign names and that has no version for the epoch."""

    name: str
    reason: str


def allowable(table: LimitTable, height_m: float) -> float | FitFailure:
    """Allowable deviation at a height.

    Parameters
    ----------
    table : LimitTable
        Where the limit stands.
    height_m : float
        Height of the structure's point above its base, above 0.

    Returns
    -------
    float or FitFailure
        Metres, or why the table has no limit there.

    Raises
    ------
    ShapeError
        If the height is not above 0.
    """
    if not (np.isfinite(height_m) and height_m > 0.0):
        raise ShapeError(f"allowable needs height_m above 0; got {height_m}")
    limit = table.rule.allowable_m(height_m)
    return FitFailure(f"{table.name}: {limit.reason}") if isinstance(limit, FitFailure) else limit


def table_of_points(
    points: Sequence[Sequence[float]], kind: LimitKind = LimitKind.UNSTATED, name: str = "own points"
) -> LimitTable:
    """Make a table of a user's own points.

    Parameters
    ----------
    points : (k, 2) sequence
        Pairs of height and allowable deviation, metres, heights increasing.
    kind : LimitKind
        What the points were written for.
    name : str
        What verdicts call the table.

    Returns
    -------
    LimitTable
        Linear between the points, no limit outside.

    Raises
    ------
    InputError
        If there are no points, a number is not above 0, or the heights do not increase.
    """
    if not points or any(len(pair) != 2 for pair in points):
        raise InputError(
            f"limits need at least one pair of height and allowable deviation; got {list(points)}"
        )
    values = np.asarray(points, dtype=np.float64)
    if not np.isfinite(values).all() or (values <= 0.0).any():
        raise InputError(f"limits need heights and deviations above 0, in metres; got {values.tolist()}")
    if (np.diff(values[:, 0]) <= 0.0).any():
        raise InputError(f"limits need heights that increase; got {values[:, 0].tolist()}")
    return LimitTable(
        name=name,
        version=1,
        rule=PointsRule(tuple(LimitPoint(float(h), float(a)) for h, a in values)),
        kind=kind,
        document="the campaign file",
        edition="",
        clause="",
        source="the campaign file",
        verified_by="the user",
        note="points given by the user",
    )
