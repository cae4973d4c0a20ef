"""A slice under a scheme and method."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column
from storage.records.section import SectionFit


@dataclass(frozen=True, slots=True, kw_only=True)
class SliceRow(SectionFit):
    """A slice of an epoch under a scheme and method, with its part in the axis."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    weight: Annotated[
        float | None, Column("weight of the centre in the axis, the largest is 1; NULL where no centre", "1")
    ]
    residual_m: Annotated[
        float | None, Column("distance of the centre from the axis; NULL for axes through two centres", "m")
    ]
    offset_east_m: Annotated[
        float | None,
        Column("east of the centre minus that of the straight axis at its height; NULL without both", "m"),
    ] = None
    offset_north_m: Annotated[
        float | None,
        Column("north of the centre minus that of the straight axis at its height; NULL without both", "m"),
    ] = None
    radius_offset_m: Annotated[
        float | None,
        Column(
            "radius minus the straight line that fits the radii of all slices over height; NULL below 3 radii",
            "m",
        ),
    ] = None
