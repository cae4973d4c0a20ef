"""The table [structure]: what is watched."""

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from tasks.settings.section import HIGHEST_M, Line, Pair, SafeId, Section, problem

Kind = Literal["chimney", "tower", "silo", "tank", "mast", "column", "stem", "square-tower"]
"""What a structure can be."""

MOST_SLOPE = 0.5
"""A designed lean beyond this is an angle in degrees, or a structure that does not stand."""

Height = Annotated[float, Field(ge=-HIGHEST_M, le=HIGHEST_M)]
Radius = Annotated[float, Field(gt=0.0, le=200.0)]


def _lower_first(shaft_z_m: tuple[float, float]) -> tuple[float, float]:
    low, high = shaft_z_m
    if low >= high:
        raise problem(f"needs the lower end first, got [{low:g}, {high:g}]", "write [lower, upper]")
    return shaft_z_m


def _rising(points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    if len(points) < 2:
        raise problem(f"needs two heights or more, got {len(points)}", "write [[height, radius], ...]")
    if any(low[0] >= high[0] for low, high in pairwise(points)):
        raise problem("heights must rise, each height once", "sort the points by height")
    return points


DesignPoint = Annotated[tuple[Height, Radius], Field(strict=False)]

Slope = Annotated[float, Field(ge=-MOST_SLOPE, le=MOST_SLOPE)]


class Structure(Section):
    """The structure that is watched, and what is roughly known of it before any scan."""

    id: SafeId = Field(description="name of the structure in files and tables")
    name: Line | None = Field(
        default=None, max_length=200, description="name for people; the id where it is missing"
    )
    kind: Kind = Field(description="what the structure is; decides the shape of its section")
    height_m: float = Field(
        gt=0.0, le=HIGHEST_M, description="H: the height at which the verticality deviation is stated [m]"
    )
    shaft_z_m: Annotated[tuple[Height, Height], Field(strict=False), AfterValidator(_lower_first)] = Field(
        description="lower and upper end of the part that is sliced, in the frame [m]"
    )
    base_xy_m: Pair = Field(
        default=(0.0, 0.0),
        description="rough position of the foot: the first two coordinates in the order of frame.axes, after"
        " frame.origin_m was subtracted; a prior only [m]",
    )
    radius_m: Annotated[tuple[Radius, Radius], Field(strict=False)] = Field(
        description="rough radius (square-tower: half the side) at the two ends of shaft_z_m; a prior only [m]"
    )

    sections: Literal["horizontal", "perpendicular"] = Field(
        default="horizontal",
        description="which cut of the shaft is round: the horizontal one, or that across the axis (built plumb, leaned"
        " since); the second takes the factor 1 + k^2 of horizontal cuts of a cone (k the taper) out of the lean",
    )

    design_radius_m: (
        Annotated[tuple[DesignPoint, ...], Field(strict=False), AfterValidator(_rising)] | None
    ) = Field(
        default=None,
        description="designed shape, [height, radius] (square-tower: half the side), heights rising, linear between; must"
        " reach over shaft_z_m; surface_map then says how far the surface is off it [m]",
    )
    design_lean: Annotated[tuple[Slope, Slope], Field(strict=False)] = Field(
        default=(0.0, 0.0), description="designed lean [east, north] over up; plumb where it is missing [1]"
    )
    design_base_xy_m: Pair | None = Field(
        default=None,
        description="where the designed axis is at z = 0 of the frame, in the order of base_xy_m; where it is missing, the"
        " designed axis meets the measured one at the lower end of shaft_z_m [m]",
    )

    @property
    def title(self) -> str:
        """Name for people."""
        return self.name or self.id
