"""The tables [schemes.X]: a user's own ways to slice."""

from itertools import pairwise
from typing import Annotated, Final, Self

from pydantic import AfterValidator, Field, model_validator

from tasks.settings.section import HIGHEST_M, Section, problem
from tasks.slicing import SCHEMES

BUILT_IN: Final = tuple(sorted({*SCHEMES, "S"}))
"""Schemes that need no entry: A to F of the paper, S for the whole surface."""

SliceHeight = Annotated[float, Field(ge=-HIGHEST_M, le=HIGHEST_M)]


def _rising(heights_m: tuple[float, ...]) -> tuple[float, ...]:
    if len(heights_m) < 2:
        raise problem(f"needs at least 2 heights for an axis, got {len(heights_m)}", "add another height")
    if any(low >= high for low, high in pairwise(heights_m)):
        raise problem("must rise, each height once", "sort the heights and drop doubles")
    return heights_m


class Scheme(Section):
    """A user's own slicing scheme: slices at an interval, or at listed heights."""

    interval_m: float | None = Field(
        default=None, ge=0.01, le=HIGHEST_M, description="distance between slices, from the lower end up [m]"
    )
    heights_m: Annotated[tuple[SliceHeight, ...], Field(strict=False), AfterValidator(_rising)] | None = (
        Field(
            default=None, description="heights of the slices in the frame, rising, instead of interval_m [m]"
        )
    )
    thickness_m: float = Field(default=0.01, ge=0.001, le=10.0, description="thickness of a slice [m]")

    @model_validator(mode="after")
    def _interval_or_heights(self) -> Self:
        if (self.interval_m is None) == (self.heights_m is None):
            raise problem("needs one of interval_m and heights_m", "write one of the two")
        return self
