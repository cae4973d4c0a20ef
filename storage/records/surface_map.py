"""What the surface of a shaft is off the shape that it should have, piece by piece."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class SurfaceMapCell:
    """A piece of a map of the surface before it has a home in an epoch; its columns stand again in SurfaceMapRow."""

    z_low_m: Annotated[float, Column("lower end of the height band in the site frame", "m")]
    z_high_m: Annotated[float, Column("upper end of the height band in the site frame", "m")]
    z_m: Annotated[float, Column("middle of the height band in the site frame", "m")]
    azimuth_deg: Annotated[
        float, Column("middle of the sector of 10 degrees, clockwise from grid north about the axis", "deg")
    ]
    n_points: Annotated[int, Column("points of the isolated shaft")]
    radius_m: Annotated[
        float | None,
        Column(
            "radius (square tower: half the side) of the best-fit straight shaft in the middle of the band: the median of"
            " its sectors; of a band without points between those of its neighbours",
            "m",
        ),
    ]
    deviation_m: Annotated[
        float | None,
        Column(
            "robust mean distance of the points from the best-fit straight shaft, positive outward; NULL without points",
            "m",
        ),
    ]
    deviation_sigma_m: Annotated[
        float | None,
        Column(
            "standard deviation of deviation_m from the scatter of its points, taken as independent; NULL where there"
            " are too few points to tell it",
            "m",
        ),
    ]
    placing_sigma_m: Annotated[
        float | None,
        Column(
            "standard deviation of deviation_m that the poses of the stations add; what all share moves the axis along",
            "m",
        ),
    ]
    design_deviation_m: Annotated[
        float | None,
        Column(
            "robust mean distance of the points from the designed shape, positive outward, with what the shaft is out of"
            " plumb; NULL without a design or without points",
            "m",
        ),
    ]
    design_sigma_m: Annotated[
        float | None,
        Column("standard deviation of design_deviation_m from the points and the poses of the stations", "m"),
    ]


@dataclass(frozen=True, slots=True)
class SurfaceMapRow(SurfaceMapCell):
    """A piece of the shaft's surface in an epoch, a height band and a sector: how far it is off its shape."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
