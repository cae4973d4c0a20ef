"""The stored axes of a structure as series over its epochs, one for every scheme and method."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import TiltRow
from tasks.trend import DAYS_A_YEAR, LeanSeries

YEAR: Final = timedelta(days=DAYS_A_YEAR)

LEAST_RATIO: Final = 1e-9
"""Of the eigenvalues of a covariance; below it is singular up to rounding."""


@dataclass(frozen=True, slots=True)
class StoredSeries:
    """A series with the rows it was made of, in order of time, and how many rows had no covariance to count with.

    ``series`` counts its years from ``origin``, the earliest epoch of any scheme and method.
    """

    rows: Sequence[TiltRow]
    series: LeanSeries
    origin: datetime
    left_out: int

    def time_of(self, years: float) -> datetime:
        """The instant of a time of the series."""
        return self.origin + years * YEAR

    @property
    def label(self) -> tuple[str, str]:
        """Scheme and method."""
        return self.rows[0].scheme, self.rows[0].method


def stored_series(tilt: Sequence[TiltRow], temperatures: Mapping[str, float]) -> list[StoredSeries]:
    """Series of every scheme and method of one structure, in the order in which these first appear.

    A movement is the lean times the height of the last epoch. The covariance of an epoch is that of its lean without
    what the form of the wall causes: that stays from epoch to epoch and is common to all. Rows without a covariance are
    left out, and so is a scheme and method that has no other.

    Parameters
    ----------
    tilt : sequence of TiltRow
        Of one structure, in any order.
    temperatures : mapping of epoch to degrees Celsius
        They are used where every epoch of a series has one.
    """
    groups: dict[tuple[str, str], list[TiltRow]] = {}
    for row in sorted(tilt, key=lambda row: row.epoch_time):
        groups.setdefault((row.scheme, row.method), []).append(row)
    order = dict.fromkeys((row.scheme, row.method) for row in tilt)
    made = [_series(groups[label], temperatures, min(row.epoch_time for row in tilt)) for label in order]
    return [one for one in made if one is not None]


def _series(
    rows: Sequence[TiltRow], temperatures: Mapping[str, float], origin: datetime
) -> StoredSeries | None:
    counted = [(row, own) for row in rows if (own := own_covariance(row)) is not None]
    if not counted:
        return None
    used = [row for row, _ in counted]
    square = used[-1].height_m ** 2
    given = [temperatures.get(row.epoch) for row in used]
    known = [value for value in given if value is not None]
    series = LeanSeries(
        times=np.array([(row.epoch_time - origin) / YEAR for row in used]),
        movements=used[-1].height_m * np.array([[row.lean_east, row.lean_north] for row in used]),
        covariances=square * np.array([own for _, own in counted]),
        temperatures=np.array(known) if len(known) == len(given) else None,
        common=square * np.mean([_form(row) for row in used], axis=0),
    )
    return StoredSeries(used, series, origin, len(rows) - len(used))


def own_covariance(row: TiltRow) -> NDArray[np.float64] | None:
    """Covariance (2, 2) of the lean of an epoch without the form of the wall; None where none is usable.

    Never below that of its points alone. Where taking the form off leaves nothing positive definite, nothing is taken off.
    """
    whole = _matrix(row.lean_cov_ee, row.lean_cov_en, row.lean_cov_nn)
    if whole is None or not _definite(whole):
        return None
    points = _matrix(row.point_cov_ee, row.point_cov_en, row.point_cov_nn)
    floor = np.zeros((2, 2)) if points is None else points
    sizes, axes = np.linalg.eigh(whole - _form(row) - floor)
    own = floor + (axes * np.maximum(sizes, 0.0)) @ axes.T
    return own if _definite(own) else whole


def _form(row: TiltRow) -> NDArray[np.float64]:
    form = _matrix(row.form_cov_ee, row.form_cov_en, row.form_cov_nn)
    return np.zeros((2, 2)) if form is None else form


def _matrix(ee: float | None, en: float | None, nn: float | None) -> NDArray[np.float64] | None:
    if ee is None or en is None or nn is None:
        return None
    found = np.array([[ee, en], [en, nn]])
    return found if np.isfinite(found).all() else None


def _definite(covariance: NDArray[np.float64]) -> bool:
    smallest, largest = np.linalg.eigvalsh(covariance)
    return bool(smallest > LEAST_RATIO * largest)
