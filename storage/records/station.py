"""How one scan was placed."""

from dataclasses import dataclass
from typing import Annotated, Final

from storage.records.column import Column

REGISTERED: Final = "registered already"
"""``start`` of a cloud that came registered: its scanners and where they stood are not known."""


@dataclass(frozen=True, slots=True)
class StationRow:
    """A station of an epoch: its scan, its pose, and how well it is known."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    station: Annotated[str, Column("id of the station")]
    scan_digest: Annotated[str | None, Column("SHA-256 of the scan file")]
    n_points: Annotated[int | None, Column("points read from the scan")]
    position_east_m: Annotated[
        float | None,
        Column(
            "adjusted east of the scanner in the site frame; NULL, as in the next six, for a cloud that came registered",
            "m",
        ),
    ]
    position_north_m: Annotated[float | None, Column("adjusted north of the scanner in the site frame", "m")]
    position_up_m: Annotated[float | None, Column("adjusted height of the scanner in the site frame", "m")]
    heading_deg: Annotated[float | None, Column("adjusted azimuth of the scanner's +y axis", "deg")]
    heading_correction_deg: Annotated[float | None, Column("adjusted minus stated heading", "deg")]
    level_east_deg: Annotated[float | None, Column("adjusted rotation about the east axis", "deg")]
    level_north_deg: Annotated[float | None, Column("adjusted rotation about the north axis", "deg")]
    overlap: Annotated[
        float | None, Column("largest share of its sampled planes that match one other station", "1")
    ]
    rmse_m: Annotated[
        float | None,
        Column("robust scale of the point-to-plane residuals of this station, not below 6 mm a pair", "m"),
    ]
    sigma_heading_deg: Annotated[float | None, Column("standard deviation of the adjusted heading", "deg")]
    sigma_level_deg: Annotated[
        float | None, Column("standard deviation of one component of the adjusted level", "deg")
    ]
    sigma_position_m: Annotated[
        float | None, Column("root mean square of the standard deviations of east, north and up", "m")
    ]
    weakest_direction: Annotated[
        str | None, Column("what the data know least of this station, beside the priors")
    ]
    state: Annotated[str, Column("ok, suspect (used; see reason) or failed (not used)")]
    reason: Annotated[str | None, Column("why the state is not ok")]
    level_check_arcsec: Annotated[
        float | None,
        Column("how far this station's side of the shaft leans against the common one", "arcsec"),
    ] = None
    level_check_chi2: Annotated[
        float | None,
        Column("chi-square (2 degrees of freedom) of that lean; above 20 the station is suspect", "1"),
    ] = None
    notes: Annotated[str | None, Column("what the reader of the scan found worth telling")] = None
    start: Annotated[
        str | None,
        Column("what the adjustment began with: as stated, or what was found in its place and why"),
    ] = None
    correction_east_m: Annotated[float | None, Column("adjusted minus stated east", "m")] = None
    correction_north_m: Annotated[float | None, Column("adjusted minus stated north", "m")] = None
    correction_up_m: Annotated[float | None, Column("adjusted minus stated height", "m")] = None
    normalised_level_east: Annotated[
        float | None,
        Column(
            "correction of the rotation about the east axis over its own standard deviation (Baarda's w); NULL, as in"
            " the next five, where nothing is stated or the scans say too little to test it",
            "1",
        ),
    ] = None
    normalised_level_north: Annotated[
        float | None, Column("the same of the rotation about the north axis", "1")
    ] = None
    normalised_heading: Annotated[
        float | None,
        Column("the same of the rotation about the up axis; positive turns the heading back", "1"),
    ] = None
    normalised_east: Annotated[float | None, Column("the same of east", "1")] = None
    normalised_north: Annotated[float | None, Column("the same of north", "1")] = None
    normalised_up: Annotated[float | None, Column("the same of the height", "1")] = None
