"""The top of the axis in the plan, with its 95 % ellipse."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import TiltRow

ELLIPSE_95: Final = 2.447746830680816
"""Square root of the 95 % quantile of chi-square with 2 degrees of freedom."""


@dataclass(frozen=True, slots=True)
class Top:
    """Where the top of an epoch is, east and north of the plumb line through the foot, metres at the height H.

    ``covariance_m2`` (2, 2) is None where it is unknown.
    """

    epoch: str
    time: datetime
    east_north_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64] | None
    allowable_m: float | None


def tops(tilts: Sequence[TiltRow]) -> list[Top]:
    """The tops of axes of one scheme and method, in the order of the rows."""
    return [_top(row) for row in tilts]


def _top(row: TiltRow) -> Top:
    covariance = None
    if row.lean_cov_ee is not None and row.lean_cov_en is not None and row.lean_cov_nn is not None:
        covariance = row.height_m**2 * np.array(
            [[row.lean_cov_ee, row.lean_cov_en], [row.lean_cov_en, row.lean_cov_nn]]
        )
    where = row.height_m * np.array([row.lean_east, row.lean_north])
    return Top(row.epoch, row.epoch_time, where, covariance, row.allowable_m)


def ellipse(
    centre: NDArray[np.float64], covariance: NDArray[np.float64], factor: float = ELLIPSE_95, n: int = 73
) -> NDArray[np.float64]:
    """Return the closed line (n, 2) of all points that are so many sigmas off the centre.

    Parameters
    ----------
    centre : (2,) array
        East and north.
    covariance : (2, 2) array
        In the square of that unit; positive semidefinite.
    factor : float
        Sigmas; the default encloses 95 % of a normal distribution in the plane.
    """
    values, vectors = np.linalg.eigh(covariance)
    angles = np.linspace(0.0, 2.0 * np.pi, n)
    axes = vectors * np.sqrt(np.maximum(values, 0.0))
    line: NDArray[np.float64] = centre + factor * np.column_stack([np.cos(angles), np.sin(angles)]) @ axes.T
    return line
