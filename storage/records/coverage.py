"""How much of the shaft was seen, and by whom."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class CoverageCell:
    """A piece of the shaft's surface before it has a home in an epoch; its columns stand again in CoverageRow."""

    z_low_m: Annotated[float, Column("lower end of the height band in the site frame", "m")]
    z_high_m: Annotated[float, Column("upper end of the height band in the site frame", "m")]
    azimuth_low_deg: Annotated[
        float, Column("where the sector begins, clockwise from grid north about the axis", "deg")
    ]
    azimuth_high_deg: Annotated[float, Column("where the sector ends", "deg")]
    n_points: Annotated[int, Column("points of the isolated shaft")]
    n_stations: Annotated[int, Column("stations that have a point there")]
    station: Annotated[str | None, Column("id of the station with the most points; NULL where none has any")]
    off_surface_m: Annotated[
        float | None,
        Column(
            "mean distance of the points from the round surface, positive outward; NULL without points", "m"
        ),
    ]


@dataclass(frozen=True, slots=True)
class CoverageRow(CoverageCell):
    """A piece of the shaft's surface in an epoch, a height band and a sector: its points and who saw it."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
