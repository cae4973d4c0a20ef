"""The axis of an epoch under a scheme and method."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class TiltRow:
    """The axis of an epoch under a scheme and method; the lean vector is the primary result."""

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    epoch_time: Annotated[datetime, Column("time of the epoch, as an instant", "UTC")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    n_slices: Annotated[int, Column("slices, failed ones too")]
    n_centres: Annotated[int, Column("slices that gave a centre to the axis")]
    base_east_m: Annotated[float, Column("east of the axis at z = 0 of the site frame", "m")]
    base_north_m: Annotated[float, Column("north of the axis at z = 0 of the site frame", "m")]
    d_east: Annotated[float, Column("east of the unit direction of the axis", "1")]
    d_north: Annotated[float, Column("north of the unit direction of the axis", "1")]
    d_up: Annotated[float, Column("up of the unit direction of the axis, above 0", "1")]
    lean_east: Annotated[float, Column("d_east / d_up", "1")]
    lean_north: Annotated[float, Column("d_north / d_up", "1")]
    lean_cov_ee: Annotated[
        float | None, Column("variance of lean_east: points, levelling and registration", "1")
    ]
    lean_cov_en: Annotated[
        float | None,
        Column("covariance of lean_east and lean_north: points, levelling and registration", "1"),
    ]
    lean_cov_nn: Annotated[
        float | None, Column("variance of lean_north: points, levelling and registration", "1")
    ]
    point_cov_ee: Annotated[
        float | None, Column("the part of lean_cov_ee that comes from the points alone", "1")
    ]
    point_cov_en: Annotated[
        float | None, Column("the part of lean_cov_en that comes from the points alone", "1")
    ]
    point_cov_nn: Annotated[
        float | None, Column("the part of lean_cov_nn that comes from the points alone", "1")
    ]
    tilt_deg: Annotated[float, Column("angle between the axis and the vertical", "deg")]
    tilt_sigma_deg: Annotated[float | None, Column("standard deviation of tilt_deg", "deg")]
    azimuth_deg: Annotated[
        float | None,
        Column("direction of lean, clockwise from grid north; NULL where the lean is below 3 sigma", "deg"),
    ]
    azimuth_sigma_deg: Annotated[
        float | None, Column("standard deviation of azimuth_deg; NULL where the lean is below 3 sigma", "deg")
    ]
    beta_deg: Annotated[
        float, Column("eq. 19 of the paper as printed: the angle between the axis and the x axis", "deg")
    ]
    verticality_permille: Annotated[float, Column("eq. 21: tangent of the tilt", "permille")]
    height_m: Annotated[float, Column("height H at which the deviation is stated", "m")]
    deviation_m: Annotated[float, Column("eq. 22: height_m times the tangent of the tilt", "m")]
    deviation_sigma_m: Annotated[float | None, Column("standard deviation of deviation_m", "m")]
    allowable_m: Annotated[
        float | None, Column("allowable deviation at height_m; NULL where no limit holds there", "m")
    ]
    verdict: Annotated[str, Column("pass, fail, cannot tell or no limit")]
    verdict_reason: Annotated[str | None, Column("which limit of which kind, or why there is none")]
    iterations: Annotated[int | None, Column("iterations of the axis; NULL for a direct line")]
    update_weight_ratio_pct: Annotated[
        float | None,
        Column("share of centres whose weight is below half of the largest; NULL for a direct line", "pct"),
    ]
    n_effective: Annotated[float | None, Column("effective number of centres, (sum w)^2 / sum w^2")]
    mean_deviation_m: Annotated[
        float | None,
        Column("eq. 18: mean distance of the centres from the axis; NULL for a direct line", "m"),
    ]
    rmse_m: Annotated[
        float | None, Column("eq. 18: root mean square distance of the centres; NULL for a direct line", "m")
    ]
    bending_m: Annotated[
        float | None,
        Column("largest distance of a parabola through the centres from the line, within the shaft", "m"),
    ]
    form_cov_ee: Annotated[
        float | None,
        Column(
            "the part of lean_cov_ee that the form of the wall causes, which stays from epoch to epoch", "1"
        ),
    ] = None
    form_cov_en: Annotated[
        float | None, Column("the part of lean_cov_en that the form of the wall causes", "1")
    ] = None
    form_cov_nn: Annotated[
        float | None, Column("the part of lean_cov_nn that the form of the wall causes", "1")
    ] = None
    covariance_source: Annotated[
        str | None,
        Column("where lean_cov_* comes from: propagation, or jackknife where that is significantly larger"),
    ] = None
    propagated_cov_ee: Annotated[
        float | None,
        Column("variance of lean_east by propagation of points, form, registration and level", "1"),
    ] = None
    propagated_cov_en: Annotated[
        float | None, Column("covariance of lean_east and lean_north by propagation", "1")
    ] = None
    propagated_cov_nn: Annotated[float | None, Column("variance of lean_north by propagation", "1")] = None
    jackknife_cov_ee: Annotated[
        float | None,
        Column(
            "variance of lean_east by leaving out one station after the other; NULL below 5 stations", "1"
        ),
    ] = None
    jackknife_cov_en: Annotated[
        float | None, Column("covariance of lean_east and lean_north by leaving out one station", "1")
    ] = None
    jackknife_cov_nn: Annotated[
        float | None, Column("variance of lean_north by leaving out one station", "1")
    ] = None
    bootstrap_cov_ee: Annotated[
        float | None,
        Column(
            "variance of lean_east by a bootstrap of blocks of the surface or of slices, a check of point_cov",
            "1",
        ),
    ] = None
    bootstrap_cov_en: Annotated[
        float | None, Column("covariance of lean_east and lean_north by the bootstrap", "1")
    ] = None
    bootstrap_cov_nn: Annotated[float | None, Column("variance of lean_north by the bootstrap", "1")] = None
    smallest_detectable_m: Annotated[
        float | None,
        Column(
            "movement of the top that a second epoch like this one would show (1 % test, 80 % power)", "m"
        ),
    ] = None
    axis_model: Annotated[
        str | None, Column("form of the axis that the data ask for: straight, parabola, cubic, spline, ...")
    ] = None
    axis_reason: Annotated[str | None, Column("why that form was chosen")] = None
    base_lean_east: Annotated[
        float | None,
        Column("east over up of the tangent at the foot of the shaft (the foundation's lean)", "1"),
    ] = None
    base_lean_north: Annotated[float | None, Column("north over up of the tangent at the foot", "1")] = None
    base_lean_sigma: Annotated[
        float | None,
        Column("standard deviation of one component of the tangent at the foot, points alone", "1"),
    ] = None
    chord_lean_east: Annotated[
        float | None, Column("east over up of the line from foot to top of the shaft", "1")
    ] = None
    chord_lean_north: Annotated[
        float | None, Column("north over up of the line from foot to top of the shaft", "1")
    ] = None
    cone_factor: Annotated[
        float | None,
        Column(
            "factor 1 + k^2 by which horizontal cuts of the tapering shaft lean more and that was taken out",
            "1",
        ),
    ] = None
    base_sigma_m: Annotated[
        float | None,
        Column(
            "standard deviation of one component of base_east_m, base_north_m, by propagation of points, form,"
            " registration and level; root mean square of both",
            "m",
        ),
    ] = None
    warning: Annotated[str | None, Column("what to mind before signing")] = None
