"""Points of a limit as a file states them: height and allowable deviation, heights rising."""

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from tasks.settings.section import HIGHEST_M, problem

LARGEST_M = 100.0
"""No limit is wider; above it, the unit is wrong."""

Kind = Literal["construction", "design", "in-service", "measurement"]
"""What a limit was written for."""

LimitPoint = Annotated[
    tuple[Annotated[float, Field(gt=0.0, le=HIGHEST_M)], Annotated[float, Field(gt=0.0, le=LARGEST_M)]],
    Field(strict=False),
]


def _rising(points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    if not points:
        raise problem("is empty", "write [[height, deviation], ...] or leave it out")
    if any(low[0] >= high[0] for low, high in pairwise(points)):
        raise problem("heights must rise, each height once", "sort the points by height")
    return points


LimitPoints = Annotated[tuple[LimitPoint, ...], Field(strict=False), AfterValidator(_rising)]
"""Pairs of height and allowable deviation, metres."""
