"""A lean that was measured by other means."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class ReferenceLeanRow:
    """A lean of an epoch that was measured by other means: total station, plumb line, inclinometer, GNSS at the top."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    epoch_time: Annotated[datetime, Column("time of the epoch, as an instant", "UTC")]
    source: Annotated[str, Column("how it was measured; unique in its epoch")]
    lean_east: Annotated[float, Column("east over up of the axis", "1")]
    lean_north: Annotated[float, Column("north over up of the axis", "1")]
    sigma: Annotated[
        float, Column("standard deviation of each component, as stated; they are independent", "1")
    ]
    tilt_deg: Annotated[float, Column("angle between the axis and the vertical", "deg")]
    tilt_sigma_deg: Annotated[float, Column("standard deviation of tilt_deg", "deg")]
    azimuth_deg: Annotated[
        float | None,
        Column("direction of lean, clockwise from grid north; NULL where the lean is below 3 sigma", "deg"),
    ]
    azimuth_sigma_deg: Annotated[
        float | None, Column("standard deviation of azimuth_deg; NULL where the lean is below 3 sigma", "deg")
    ]
    height_m: Annotated[float, Column("height H at which the deviation is stated", "m")]
    deviation_m: Annotated[float, Column("height_m times the tangent of the tilt", "m")]
    deviation_sigma_m: Annotated[float, Column("standard deviation of deviation_m", "m")]
