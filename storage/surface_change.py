"""A row of the view ``surface_changes``, which SQL makes of the stored tables."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records import Column


@dataclass(frozen=True, slots=True)
class SurfaceChangeRow:
    """A piece of the shaft's surface in an epoch against the reference epoch of its structure.

    Each epoch is measured from its own axis, so that a movement of the whole shaft is no change here; those are in
    ``changes``, and in ``design_change_m`` of a shaft whose design and its place are stated.
    """

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    epoch_time: Annotated[datetime, Column("time of the epoch, as an instant", "UTC")]
    reference_epoch: Annotated[str, Column("epoch from which the change is counted")]
    z_low_m: Annotated[float, Column("lower end of the height band in the site frame", "m")]
    z_high_m: Annotated[float, Column("upper end of the height band in the site frame", "m")]
    z_m: Annotated[float, Column("middle of the height band in the site frame", "m")]
    azimuth_deg: Annotated[
        float, Column("middle of the sector of 10 degrees, clockwise from grid north", "deg")
    ]
    change_m: Annotated[
        float | None,
        Column("deviation_m minus that of the reference epoch; NULL where one of them has no points", "m"),
    ]
    lod95_m: Annotated[
        float | None,
        Column(
            "level of detection: 1.96 times the root of the summed variances of the points, plus the same of the poses",
            "m",
        ),
    ]
    significant: Annotated[
        bool | None,
        Column("whether change_m is beyond lod95_m; of pieces that did not change 1 in 20 is, or fewer"),
    ]
    radius_change_m: Annotated[
        float | None,
        Column("radius_m minus that of the reference epoch: what the whole band has in common", "m"),
    ]
    design_change_m: Annotated[
        float | None,
        Column("design_deviation_m minus that of the reference epoch: local change and lean together", "m"),
    ]
    design_lod95_m: Annotated[
        float | None, Column("level of detection of design_change_m: 1.96 times its standard deviation", "m")
    ]
