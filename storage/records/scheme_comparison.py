"""The schemes and reference measurements of an epoch beside the primary."""

from dataclasses import dataclass
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True)
class SchemeComparisonRow:
    """A scheme and method of an epoch, or a reference measurement, against the primary: difference, workload, advice.

    Schemes of one epoch share poses and points: the covariance of a difference is not the sum of both.
    """

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    compared: Annotated[str, Column("scheme/method, or the source of a reference measurement")]
    scheme: Annotated[str | None, Column("slicing scheme; NULL for a reference measurement")]
    method: Annotated[str | None, Column("paper, robust or surface; NULL for a reference measurement")]
    against: Annotated[str, Column("what it is compared with: scheme/method, or the source of a reference")]
    height_m: Annotated[float, Column("height H at which sigmas and differences are stated", "m")]
    n_slices: Annotated[int | None, Column("slices, failed ones too (of S: bands); NULL for a reference")]
    n_centres: Annotated[int | None, Column("slices that gave a centre to the axis; NULL for a reference")]
    n_points: Annotated[
        int | None, Column("points that the fits used; NULL where slices are not stored, and for a reference")
    ]
    workload_ratio: Annotated[
        float | None,
        Column("slices as a multiple of those of against; NULL where one of the two is not sliced", "1"),
    ]
    sigma_m: Annotated[
        float | None,
        Column(
            "standard deviation of one component of the axis at height_m: points, levelling, registration",
            "m",
        ),
    ]
    point_sigma_m: Annotated[
        float | None, Column("the part of sigma_m that comes from the points; NULL for a reference", "m")
    ]
    d_lean_east: Annotated[
        float | None, Column("lean_east minus that of against; NULL where there is no other axis", "1")
    ]
    d_lean_north: Annotated[
        float | None, Column("lean_north minus that of against; NULL where there is no other axis", "1")
    ]
    d_cov_ee: Annotated[float | None, Column("variance of d_lean_east; what both share is cancelled", "1")]
    d_cov_en: Annotated[
        float | None, Column("covariance of d_lean_east and d_lean_north; what both share is cancelled", "1")
    ]
    d_cov_nn: Annotated[float | None, Column("variance of d_lean_north; what both share is cancelled", "1")]
    shared: Annotated[
        str | None,
        Column("what the covariance takes as shared: slices, all points, poses alone, or nothing"),
    ]
    d_top_m: Annotated[float | None, Column("length of the difference at height_m", "m")]
    d_sigma_top_m: Annotated[
        float | None,
        Column(
            "standard deviation of the difference along its direction; the largest where there is none", "m"
        ),
    ]
    chi2: Annotated[
        float | None, Column("d' C^-1 d of the difference; NULL where its covariance is unknown or singular")
    ]
    p_value: Annotated[
        float | None,
        Column(
            "probability of such a chi2 or a larger one if both saw the same axis, 2 degrees of freedom", "1"
        ),
    ]
    significant: Annotated[bool | None, Column("whether p_value is below 0.01")]
    best: Annotated[
        str | None, Column("the axis of the smallest sigma_m in the epoch; NULL where no sigma is known")
    ]
    excess_pct: Annotated[
        float | None, Column("by how much sigma_m is above that of best; NULL for a reference", "pct")
    ]
    is_enough: Annotated[
        bool | None,
        Column("whether so many slices are enough; NULL for a reference and where it cannot be told"),
    ]
    is_recommended: Annotated[bool, Column("of those that are enough the one of the fewest slices")]
    reason: Annotated[str | None, Column("why it is enough or not, or why there is no difference")]
