"""A table of allowable deviations, with what one must know before believing it."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

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


class LimitRule(Protocol):
    """How the allowable deviation follows from the height."""

    def allowable_m(self, height_m: float) -> float | FitFailure:
        """Allowable deviation at a height above 0, metres, or why there is none."""


@dataclass(frozen=True, slots=True)
class LimitPoint:
    """The allowable deviation at one height."""

    height_m: float
    allowable_m: float


@dataclass(frozen=True, slots=True)
class PointsRule:
    """Linear between the given heights; no limit outside them."""

    points: tuple[LimitPoint, ...]

    def allowable_m(self, height_m: float) -> float | FitFailure:
        """Allowable deviation at a height, metres, or why there is none."""
        low, high = self.points[0].height_m, self.points[-1].height_m
        if not low <= height_m <= high:
            return FitFailure(f"the table holds from {low:g} m to {high:g} m; the height is {height_m:g} m")
        heights = [point.height_m for point in self.points]
        return float(np.interp(height_m, heights, [point.allowable_m for point in self.points]))


@dataclass(frozen=True, slots=True)
class RatioRule:
    """A share of the height, from a lowest height on, up to a largest deviation where there is one."""

    ratio: float
    above_m: float
    largest_m: float | None

    def allowable_m(self, height_m: float) -> float | FitFailure:
        """Allowable deviation at a height, metres, or why there is none."""
        if height_m <= self.above_m:
            return FitFailure(f"the rule holds above {self.above_m:g} m; the height is {height_m:g} m")
        share = self.ratio * height_m
        return share if self.largest_m is None else min(share, self.largest_m)


@dataclass(frozen=True, slots=True)
class LimitTable:
    """A rule and its papers.

    ``version`` counts the changes of the data here; ``verified_by`` names who compared them with the
    document itself, None where nobody has.
    """

    name: str
    version: int
    rule: LimitRule
    kind: LimitKind
    document: str
    edition: str
    clause: str
    source: str
    verified_by: str | None
    note: str

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
