"""What changed between an epoch and the reference epoch, quantity by quantity."""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated

from storage.records.column import Column


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangeTestRow:
    """One quantity of an epoch against the reference epoch, under one scheme and method.

    ``quantity``: ``lean``, ``base`` (the axis at z = 0), ``bending``, ``radius`` (the profile), ``centres`` (all centres
    of slices that both epochs have, the global congruency test).
    """

    structure: Annotated[str, Column("id of the structure")]
    epoch: Annotated[str, Column("id of the epoch")]
    epoch_time: Annotated[datetime, Column("time of the epoch, as an instant", "UTC")]
    reference_epoch: Annotated[str, Column("epoch from which the change is counted")]
    reference_time: Annotated[datetime, Column("time of the reference epoch", "UTC")]
    scheme: Annotated[str, Column("slicing scheme")]
    method: Annotated[str, Column("paper, robust or surface")]
    quantity: Annotated[str, Column("lean, base, bending, radius or centres")]
    basis: Annotated[
        str, Column("how it was counted: free, or radius held (the same radius profile in both epochs)")
    ]
    d_east: Annotated[
        float | None,
        Column("change to the east, metres, of the lean metres a metre; NULL for radius, centres"),
    ]
    d_north: Annotated[float | None, Column("change to the north, in the same unit")]
    d_cov_ee: Annotated[
        float | None, Column("variance of d_east, common parts cancelled, in the square of its unit")
    ]
    d_cov_en: Annotated[float | None, Column("covariance of d_east and d_north")]
    d_cov_nn: Annotated[float | None, Column("variance of d_north")]
    size_m: Annotated[
        float | None,
        Column(
            "size of the change: of the lean at height_m, of the base, of the sagitta, largest of radius or centres",
            "m",
        ),
    ]
    sigma_m: Annotated[float | None, Column("standard deviation of size_m along its direction", "m")]
    height_m: Annotated[float, Column("height H at which a change of the lean is stated", "m")]
    statistic: Annotated[float | None, Column("d' C^-1 d; NULL where nothing can be tested")]
    freedom: Annotated[int | None, Column("degrees of freedom of the statistic")]
    p_value: Annotated[
        float | None, Column("probability of such a statistic or a larger one if nothing changed", "1")
    ]
    significant: Annotated[bool | None, Column("whether p_value is below 0.01")]
    smallest_detectable_m: Annotated[
        float | None, Column("size_m that the 1 % test finds in 80 % of cases, in the worst direction", "m")
    ]
    run: Annotated[str, Column("run that published the epoch as it was compared")]
    reference_run: Annotated[str, Column("run that published the reference epoch as it was compared")]
    code_version: Annotated[str, Column("digest of the code that compared them")]
    z_low_m: Annotated[float | None, Column("where it changed: from this height", "m")] = None
    z_high_m: Annotated[float | None, Column("where it changed: up to this height", "m")] = None
    reason: Annotated[str | None, Column("what was found where, or why nothing could be tested")] = None
