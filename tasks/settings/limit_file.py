"""A user's own tables of limits: a TOML file of [[limits]], several versions of a table in one file."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, ValidationError, model_validator

from tasks.limits import TABLES
from tasks.settings.limit_points import LARGEST_M, Kind, LimitPoints
from tasks.settings.problems import Problem, problems_of
from tasks.settings.section import CONTROL, HIGHEST_M, SafeId, Section, problem
from tasks.settings.toml_file import LIMIT_FILE, input_error, read_toml

MOST_SHARE = 0.5
"""Beyond this share of the height a limit is a percentage, or nothing that stands."""

Length = Annotated[float, Field(gt=0.0, le=LARGEST_M)]
Text = Annotated[str, Field(max_length=1000)]


class StatedLimit(Section):
    """A table of limits with its papers: points, or a share of the height."""

    name: SafeId = Field(description="name of the table")
    version: int = Field(default=1, ge=1, description="counts the changes of the table")
    valid_from: date | None = Field(
        default=None,
        description="epochs from this date on are judged by this version; all where it is missing",
    )
    kind: Kind = Field(description="what the limit was written for")
    document: Text = Field(min_length=1, description="where the limit stands")
    edition: Text = Field(default="", description="edition of the document")
    clause: Text = Field(default="", description="clause or table of the document")
    source: Text = Field(min_length=1, description="where the figures were taken from")
    verified_by: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        default=None, description="who compared them with the document itself; nobody where it is missing"
    )
    note: Text = Field(default="", description="what else one must know")
    points_m: LimitPoints | None = Field(
        default=None,
        description="[height, allowable deviation], rising; linear between, no limit outside [m]",
    )
    ratio: Annotated[float, Field(gt=0.0, le=MOST_SHARE)] | None = Field(
        default=None, description="allowable deviation as a share of the height [1]"
    )
    one_in: Annotated[float, Field(ge=2.0, le=1e6)] | None = Field(
        default=None, description="the same the other way round: 250 is a 250th of the height [1]"
    )
    at_least_m: Length | None = Field(default=None, description="the share is never taken for less [m]")
    at_most_m: Length | None = Field(default=None, description="the share is never taken for more [m]")
    above_m: float = Field(
        default=0.0, ge=0.0, le=HIGHEST_M, description="the share holds above this height [m]"
    )
    up_to_m: Annotated[float, Field(gt=0.0, le=HIGHEST_M)] | None = Field(
        default=None, description="and up to this one [m]"
    )
    sigmas: float = Field(
        default=1.0,
        gt=0.0,
        le=10.0,
        description="of kind measurement: the figure bounds so many standard deviations of the deviation [1]",
    )

    @model_validator(mode="after")
    def _has_one_rule(self) -> Self:
        rules = [name for name in ("points_m", "ratio", "one_in") if getattr(self, name) is not None]
        if len(rules) != 1:
            raise problem(
                f"needs one of points_m, ratio and one_in, got {' and '.join(rules) or 'none'}",
                "keep one of them",
            )
        bounds = {"at_least_m", "at_most_m", "above_m", "up_to_m"} & self.model_fields_set
        if self.points_m is not None and bounds:
            raise problem(
                f"{', '.join(sorted(bounds))} goes with ratio or one_in",
                "points_m end where their heights end",
            )
        if self.up_to_m is not None and self.up_to_m <= self.above_m:
            raise problem("up_to_m must be higher than above_m", "write the higher one in up_to_m")
        if None not in (self.at_least_m, self.at_most_m) and self.at_least_m > self.at_most_m:  # type: ignore[operator]
            raise problem("at_least_m must not be more than at_most_m", "write the smaller one in at_least_m")
        if self.sigmas != 1.0 and self.kind != "measurement":
            raise problem(
                "sigmas goes with kind measurement", "drop it: the guard band is the same for all limits"
            )
        return self

    @property
    def share(self) -> float:
        """The share of the height; 0 where the table has points."""
        return 1.0 / self.one_in if self.one_in is not None else self.ratio or 0.0


class LimitFile(Section):
    """A file of tables of limits."""

    limits: Annotated[tuple[StatedLimit, ...], Field(strict=False, min_length=1)] = Field(
        description="tables of limits, each with a name; several versions of one in any order"
    )


def load_limits(path: Path) -> tuple[StatedLimit, ...]:
    """Read and check a file of limits.

    Raises
    ------
    InputError
        One line for every problem, each ``FILE: where: what; hint``.
    """
    raw = read_toml(path, LIMIT_FILE)
    try:
        limits = LimitFile.model_validate(raw).limits
    except ValidationError as error:
        raise input_error(path, list(problems_of(error, raw, LimitFile))) from error
    problems = list(_problems_between(limits))
    if problems:
        raise input_error(path, problems)
    return limits


def stated_file(raw: Mapping[str, object]) -> str | None:
    """The file of limits that a campaign names, before the campaign is checked."""
    limits = raw.get("limits")
    file = limits.get("file") if isinstance(limits, Mapping) else None
    is_name = isinstance(file, str) and file.strip() and not CONTROL.search(file)
    return file if is_name else None


def _problems_between(limits: Sequence[StatedLimit]) -> Iterator[Problem]:
    for name in dict.fromkeys(limit.name for limit in limits):
        where = f"limits {name!r}"
        if name in TABLES:
            yield Problem(where, "is the name of a shipped table", "choose another")
        for key in ("version", "valid_from"):
            counts = Counter(getattr(limit, key) for limit in limits if limit.name == name)
            for value, n in counts.items():
                if n > 1:
                    stated = "no valid_from" if value is None else f"{key} = {value}"
                    yield Problem(
                        where, f"{n} tables of that name have {stated}", "each version needs its own"
                    )
