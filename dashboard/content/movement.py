"""How the top moved since an epoch that the reader chooses."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from dashboard.content.direction import Direction
from storage.records import TiltRow
from storage.views import ChangeRow

SUM_OF_BOTH = "sum of both"


@dataclass(frozen=True, slots=True)
class Movement:
    """The top of an epoch against that of the reference, in metres at the height H, with its covariance.

    ``covariance_m2`` (2, 2) is None where one of the two is unknown. ``basis`` is that of the view ``changes``;
    where nothing is cancelled the covariance is too large rather than too small.
    """

    epoch: str
    time: datetime
    east_north_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64] | None
    size_m: float
    sigma_m: float | None
    significant: bool | None
    p_value: float | None
    detectable_m: float | None
    basis: str

    def turned(self, direction: Direction) -> NDArray[np.float64]:
        """Return the movement (2,) along and across a direction, metres."""
        return direction.turn(self.east_north_m)

    def sigmas_m(self, direction: Direction) -> NDArray[np.float64] | None:
        """Return the standard deviations (2,) along and across a direction, metres."""
        if self.covariance_m2 is None:
            return None
        return np.sqrt(np.diag(direction.turn_covariance(self.covariance_m2)))


def movements_since(
    reference: str, tilts: Sequence[TiltRow], changes: Sequence[ChangeRow]
) -> Mapping[str, Movement]:
    """Say for every other epoch how far its top is from that of the reference.

    Parameters
    ----------
    reference : str
        The epoch from which movements are counted.
    tilts, changes : sequences
        Rows of one structure, scheme and method. Where the catalog counts from the same epoch, its figures are
        taken; else leans are subtracted and covariances added, and nothing is called significant.

    Returns
    -------
    mapping
        Epoch to its movement; empty where the reference has no axis.
    """
    stored = {row.epoch: _stored(row) for row in changes if row.reference_epoch == reference}
    first = next((row for row in tilts if row.epoch == reference), None)
    if first is None:
        return stored
    plain = {row.epoch: _difference(row, first) for row in tilts if row.epoch != reference}
    return {**plain, **stored}


def _stored(row: ChangeRow) -> Movement:
    height = row.height_m
    covariance = _matrix(row.d_cov_ee, row.d_cov_en, row.d_cov_nn)
    return Movement(
        epoch=row.epoch,
        time=row.epoch_time,
        east_north_m=height * np.array([row.d_lean_east, row.d_lean_north]),
        covariance_m2=None if covariance is None else height**2 * covariance,
        size_m=row.d_top_m,
        sigma_m=row.sigma_top_m,
        significant=row.significant,
        p_value=row.p_value,
        detectable_m=row.smallest_detectable_m,
        basis=row.basis,
    )


def _difference(row: TiltRow, first: TiltRow) -> Movement:
    moved = row.height_m * np.array([row.lean_east - first.lean_east, row.lean_north - first.lean_north])
    size = float(math.hypot(*moved))
    one = _matrix(row.lean_cov_ee, row.lean_cov_en, row.lean_cov_nn)
    other = _matrix(first.lean_cov_ee, first.lean_cov_en, first.lean_cov_nn)
    covariance = None if one is None or other is None else row.height_m**2 * (one + other)
    sigma = None
    if covariance is not None:
        along = moved / size if size > 0.0 else np.array([1.0, 0.0])
        sigma = math.sqrt(float(along @ covariance @ along))
    return Movement(row.epoch, row.epoch_time, moved, covariance, size, sigma, None, None, None, SUM_OF_BOTH)


def _matrix(ee: float | None, en: float | None, nn: float | None) -> NDArray[np.float64] | None:
    if ee is None or en is None or nn is None:
        return None
    return np.array([[ee, en], [en, nn]])
