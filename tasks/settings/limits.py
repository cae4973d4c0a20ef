"""The table [limits]: how far from plumb the structure may be."""

from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator, Field

from tasks.limits import TABLES
from tasks.settings.section import HIGHEST_M, Section, problem

LimitPoint = Annotated[
    tuple[Annotated[float, Field(gt=0.0, le=HIGHEST_M)], Annotated[float, Field(gt=0.0, le=100.0)]],
    Field(strict=False),
]


def _rising(points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    if not points:
        raise problem("is empty", "write [[height, deviation], ...] or leave it out")
    if any(low[0] >= high[0] for low, high in pairwise(points)):
        raise problem("heights must rise, each height once", "sort the points by height")
    return points


def _shipped(name: str) -> str:
    if name not in TABLES:
        raise problem(f"unknown table of limits {name!r}", f"known: {', '.join(sorted(TABLES))}")
    return name


class Limits(Section):
    """Allowable verticality deviation by height: a shipped table, or points of one's own."""

    table: Annotated[str, AfterValidator(_shipped)] | None = Field(
        default=None, description=f"name of a shipped table of limits: {', '.join(sorted(TABLES))}"
    )
    verticality_m: Annotated[tuple[LimitPoint, ...], Field(strict=False), AfterValidator(_rising)] | None = (
        Field(
            default=None,
            description="points [height, allowable deviation], rising; linear between, no limit outside;"
            " they win over table [m]",
        )
    )
