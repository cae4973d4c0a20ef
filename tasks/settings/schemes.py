"""The tables [schemes.X]: a user's own ways to slice."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Final, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from tasks.axis import AXES
from tasks.contours import CONTOURS
from tasks.settings.problems import nearest
from tasks.settings.section import HIGHEST_M, Section, problem
from tasks.slicing import SCHEMES, AdaptiveCut, SlicingScheme, user_scheme
from tasks.surface import SURFACES

BUILT_IN: Final = tuple(sorted({*SCHEMES, "S"}))
"""Schemes that need no entry: A to F of the paper, S for the whole surface."""

WAYS: Final = ("interval_m", "heights_m", "adaptive", "surface")
"""What says where the slices lie; a scheme has one of them."""

OF_SLICES: Final = {"adaptive": ("thickness_m",), "surface": ("thickness_m", "contour", "axis")}
"""What has no meaning beside a way."""

SliceHeight = Annotated[float, Field(ge=-HIGHEST_M, le=HIGHEST_M)]

SigmaCenter = Annotated[float, Field(ge=1e-5, le=1.0)]


def _rising(heights_m: tuple[float, ...]) -> tuple[float, ...]:
    if len(heights_m) < 2:
        raise problem(f"needs at least 2 heights for an axis, got {len(heights_m)}", "add another height")
    if any(low >= high for low, high in pairwise(heights_m)):
        raise problem("must rise, each height once", "sort the heights and drop doubles")
    return heights_m


def one_of(variants: Mapping[str, object], what: str) -> Callable[[str], str]:
    """Make a check that a name is that of a variant; the answer to a wrong one names the nearest."""

    def check(name: str) -> str:
        if name not in variants:
            raise problem(f"unknown {what} {name!r}", nearest(name, sorted(variants)))
        return name

    return check


class Adaptive(Section):
    """Slices whose thickness follows the points, so that every centre reaches a wanted standard deviation."""

    sigma_center_m: SigmaCenter = Field(
        description="wanted standard deviation of the less certain component of a centre [m]"
    )
    least_thickness_m: float = Field(
        default=0.02, ge=0.005, le=10.0, description="no slice is thinner than this [m]"
    )
    most_thickness_m: float = Field(
        default=2.0, ge=0.005, le=50.0, description="no slice is thicker than this [m]"
    )

    @model_validator(mode="after")
    def _least_is_less(self) -> Self:
        if self.least_thickness_m > self.most_thickness_m:
            raise problem(
                f"least_thickness_m = {self.least_thickness_m:g} is above most_thickness_m = "
                f"{self.most_thickness_m:g}",
                "write the smaller thickness as least_thickness_m",
            )
        return self


def _member(value: object) -> str:
    return "table" if isinstance(value, Mapping | Adaptive) else "sigma"


Following = Annotated[
    Annotated[SigmaCenter, Tag("sigma")] | Annotated[Adaptive, Tag("table")], Discriminator(_member)
]
"""The wanted sigma alone, or with bounds of the thickness."""


class Scheme(Section):
    """A user's own scheme: slices at an interval, at listed heights or following the points, or the whole surface."""

    interval_m: float | None = Field(
        default=None, ge=0.01, le=HIGHEST_M, description="distance between slices, from the lower end up [m]"
    )
    heights_m: Annotated[tuple[SliceHeight, ...], Field(strict=False), AfterValidator(_rising)] | None = (
        Field(
            default=None, description="heights of the slices in the frame, rising, instead of interval_m [m]"
        )
    )
    adaptive: Following | None = Field(
        default=None,
        description="wanted standard deviation of a centre, instead of interval_m: slices as thick as it needs [m];"
        " or a table with sigma_center_m and bounds of the thickness",
    )
    surface: Annotated[str, AfterValidator(one_of(SURFACES, "surface model"))] | None = Field(
        default=None,
        description="model of the whole surface, instead of interval_m: no slices, all points are fitted at once: "
        + ", ".join(sorted(SURFACES)),
    )
    thickness_m: float = Field(default=0.01, ge=0.001, le=10.0, description="thickness of a slice [m]")
    contour: Annotated[str, AfterValidator(one_of(CONTOURS, "contour model"))] = Field(
        default="robust_circle",
        description=f"contour model of method robust: {', '.join(sorted(CONTOURS))}",
    )
    axis: Annotated[str, AfterValidator(one_of(AXES, "axis estimator"))] = Field(
        default="robust_line", description=f"axis estimator of method robust: {', '.join(sorted(AXES))}"
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        stated = [way for way in WAYS if getattr(self, way) is not None]
        if len(stated) != 1:
            got = " and ".join(stated) or "none"
            raise problem(f"needs one of {', '.join(WAYS)}, got {got}", "write one of them")
        idle = [key for key in OF_SLICES.get(stated[0], ()) if key in self.model_fields_set]
        if idle:
            raise problem(f"{idle[0]} has no meaning beside {stated[0]}", "drop one of the two")
        return self

    @property
    def cut(self) -> AdaptiveCut | None:
        """What slices that follow the points are to reach, with its defaults."""
        if self.adaptive is None:
            return None
        stated = self.adaptive
        table = stated if isinstance(stated, Adaptive) else Adaptive(sigma_center_m=stated)
        return AdaptiveCut(**table.model_dump())

    def as_scheme(self, name: str) -> SlicingScheme:
        """State it in the words of the stages."""
        scheme = user_scheme(
            name, self.interval_m, self.heights_m, self.thickness_m, adaptive=self.cut, surface=self.surface
        )
        return replace(scheme, robust_contour=self.contour, robust_axis=self.axis)
