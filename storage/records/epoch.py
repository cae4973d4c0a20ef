"""What was measured in one epoch."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class EpochRow:
    """An epoch: one measuring campaign of a structure."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    epoch_time: Annotated[datetime, Column("time of the epoch, as an instant", "UTC")]
    run: Annotated[str, Column("run that published this row")]
    state: Annotated[
        str, Column("ok, degraded (something failed, the rest was processed) or failed (no result)")
    ]
    reason: Annotated[str | None, Column("what failed, where the state is not ok")]
    n_stations: Annotated[int, Column("stations named in the campaign file; 1 for a registered cloud")]
    n_stations_used: Annotated[int, Column("stations that entered the result")]
    n_points_in: Annotated[int, Column("points read from all scans")]
    n_points_used: Annotated[int, Column("points of the isolated shaft")]
    is_reference: Annotated[bool, Column("changes are counted from this epoch")]
    height_m: Annotated[float, Column("height H at which the deviation is stated", "m")]
    campaign_digest: Annotated[str, Column("SHA-256 of the filled-in campaign settings of the run")]
    code_version: Annotated[str, Column("digest of the code that made the results")]
    schema_version: Annotated[int, Column("version of the stored tables")]
    coverage_deg: Annotated[
        float | None, Column("circumference of the shaft with points, mean over the height bands", "deg")
    ] = None
    stations_sigma_arcsec: Annotated[
        float | None,
        Column(
            "predicted standard deviation of one component of the lean vector with these stations", "arcsec"
        ),
    ] = None
    next_station_azimuth_deg: Annotated[
        float | None,
        Column(
            "where one more station would help most, clockwise from grid north as seen from the axis", "deg"
        ),
    ] = None
    next_station_sigma_arcsec: Annotated[
        float | None, Column("stations_sigma_arcsec with that station, set up like the others", "arcsec")
    ] = None
