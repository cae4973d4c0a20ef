"""The contour of one slice, before it has a home in an epoch."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class SectionFit:
    """A slice that was cut and fitted; its columns stand again in SliceRow."""

    slice_index: Annotated[int, Column("number of the slice from the bottom, from 0")]
    z_m: Annotated[float, Column("height of the slice's centre in the site frame", "m")]
    thickness_m: Annotated[float, Column("thickness of the slice", "m")]
    n_points: Annotated[int, Column("points in the slice")]
    n_points_fit: Annotated[int | None, Column("points with a weight above zero in the contour fit")]
    center_east_m: Annotated[float | None, Column("east of the contour's centre", "m")]
    center_north_m: Annotated[float | None, Column("north of the contour's centre", "m")]
    radius_m: Annotated[
        float | None, Column("radius of the contour; mean distance of the vertices for a vertex mean", "m")
    ]
    sigma_center_m: Annotated[
        float | None,
        Column("standard deviation of one component of the centre, root mean square of both", "m"),
    ]
    center_cov_ee: Annotated[
        float | None, Column("variance of the centre's east, from the points alone", "m2")
    ]
    center_cov_en: Annotated[
        float | None, Column("covariance of the centre's east and north, from the points alone", "m2")
    ]
    center_cov_nn: Annotated[
        float | None, Column("variance of the centre's north, from the points alone", "m2")
    ]
    rmse_m: Annotated[float | None, Column("root mean square distance of the points from the contour", "m")]
    arc_coverage_deg: Annotated[
        float | None, Column("share of the circumference that has points, in sectors of 5 degrees", "deg")
    ]
    state: Annotated[str, Column("ok or failed")]
    reason: Annotated[str | None, Column("why the slice failed")]
    contour: Annotated[str | None, Column("contour model that gave the centre; NULL where none did")] = None
    contour_reason: Annotated[
        str | None, Column("why that model was chosen, where the variant chooses among several")
    ] = None
    noise_m: Annotated[
        float | None, Column("robust standard deviation of the points about the contour", "m")
    ] = None
    roundness_m: Annotated[
        float | None,
        Column(
            "largest minus smallest radius of the fitted contour about its centre; NULL for a circle", "m"
        ),
    ] = None
    ovality_m: Annotated[
        float | None,
        Column(
            "amplitude of the second harmonic of the radius (an ellipse: half of a - b); NULL for a circle",
            "m",
        ),
    ] = None
    ovality_azimuth_deg: Annotated[
        float | None,
        Column(
            "azimuth of the larger diameter, 0 to 180, clockwise from grid north; NULL for a circle", "deg"
        ),
    ] = None


def failed_section(
    slice_index: int, z_m: float, thickness_m: float, n_points: int, reason: str
) -> SectionFit:
    """The row of a slice that gave no centre."""
    return SectionFit(
        slice_index=slice_index,
        z_m=z_m,
        thickness_m=thickness_m,
        n_points=n_points,
        n_points_fit=None,
        center_east_m=None,
        center_north_m=None,
        radius_m=None,
        sigma_center_m=None,
        center_cov_ee=None,
        center_cov_en=None,
        center_cov_nn=None,
        rmse_m=None,
        arc_coverage_deg=None,
        state="failed",
        reason=reason,
    )
