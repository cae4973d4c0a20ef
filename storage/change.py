"""A row of the view ``changes``, which SQL makes of the stored tables."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records import Column


@dataclass(frozen=True, slots=True)
class ChangeRow:
    """An epoch against the reference epoch of its structure, under one scheme and method.

    ``basis`` says how it was counted. Where the epochs were compared with what they have in common cancelled, the figures
    are those of ``change_tests``; where that is not done yet, the covariance is the sum of both, and so too large rather
    than too small.
    """

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    epoch_time: Annotated[datetime, Column("time of the epoch, as an instant", "UTC")]
    reference_epoch: Annotated[str, Column("epoch from which the change is counted")]
    reference_time: Annotated[datetime, Column("time of the reference epoch", "UTC")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    height_m: Annotated[float, Column("height H at which the change is stated", "m")]
    d_lean_east: Annotated[float, Column("change of lean_east since the reference epoch", "1")]
    d_lean_north: Annotated[float, Column("change of lean_north since the reference epoch", "1")]
    d_cov_ee: Annotated[float | None, Column("variance of d_lean_east", "1")]
    d_cov_en: Annotated[float | None, Column("covariance of d_lean_east and d_lean_north", "1")]
    d_cov_nn: Annotated[float | None, Column("variance of d_lean_north", "1")]
    d_top_m: Annotated[float, Column("horizontal movement of the axis at height_m relative to z = 0", "m")]
    sigma_top_m: Annotated[
        float | None,
        Column("standard deviation of the movement along its direction; the largest where none moved", "m"),
    ]
    chi2: Annotated[
        float | None, Column("d' C^-1 d of the change and its covariance; NULL where that is unknown")
    ]
    p_value: Annotated[
        float | None,
        Column("probability of such a chi2 or a larger one if nothing moved, 2 degrees of freedom", "1"),
    ]
    significant: Annotated[bool | None, Column("whether p_value is below 0.01")]
    smallest_detectable_m: Annotated[
        float | None,
        Column("movement at height_m that the 1 % test finds in 80 % of cases, in the worst direction", "m"),
    ]
    basis: Annotated[
        str,
        Column(
            "free: common parts cancelled; radius held: the same radius profile taken for both epochs besides; sum of both:"
            " not compared yet, nothing cancelled"
        ),
    ]
