"""The difference of any two epochs of a structure, scheme by scheme, with its significance."""

import math
from dataclasses import dataclass
from typing import Final

from storage.records import TiltRow
from storage.views import ChangeRow, tilt_rows
from storage.workspace import Workspace

SIGNIFICANT_P: Final = 0.01
"""A difference is significant below this probability (the same as in the view ``changes``)."""

DETECTABLE_FACTOR: Final = 3.7257
"""sqrt(13.8807): the noncentrality that a 1 % test of two degrees of freedom finds in 80 % of cases."""


def epoch_differences(workspace: Workspace, structure: str, epoch: str, reference: str) -> list[ChangeRow]:
    """Compare two epochs under every scheme and method that both have.

    The covariance of a difference is the sum of both: what the epochs share (pillars, the scanner's own errors)
    is not cancelled, so the test errs on the side of no change.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    before = {(row.scheme, row.method): row for row in tilt_rows(workspace, structure, reference)}
    after = tilt_rows(workspace, structure, epoch)
    return [_difference(row, base) for row in after if (base := before.get((row.scheme, row.method)))]


@dataclass(frozen=True, slots=True)
class _Test:
    """Covariance of a difference of lean vectors, and what it says of the difference; None where unknown."""

    ee: float | None
    en: float | None
    nn: float | None
    chi2: float | None = None
    sigma: float | None = None
    largest: float | None = None

    @property
    def p_value(self) -> float | None:
        """Exact for two degrees of freedom."""
        return None if self.chi2 is None else math.exp(-self.chi2 / 2.0)


def _tested(later: TiltRow, base: TiltRow, east: float, north: float) -> _Test:
    ee = _sum(later.lean_cov_ee, base.lean_cov_ee)
    en = _sum(later.lean_cov_en, base.lean_cov_en)
    nn = _sum(later.lean_cov_nn, base.lean_cov_nn)
    if ee is None or en is None or nn is None or ee <= 0.0 or ee * nn - en * en <= 0.0:
        return _Test(ee, en, nn)
    chi2 = (nn * east**2 - 2.0 * en * east * north + ee * north**2) / (ee * nn - en * en)
    largest = math.sqrt((ee + nn) / 2.0 + math.hypot((ee - nn) / 2.0, en))
    moved = math.hypot(east, north)
    along = math.sqrt(ee * east**2 + 2.0 * en * east * north + nn * north**2)
    return _Test(ee, en, nn, chi2, along / moved if moved > 0.0 else largest, largest)


def _difference(later: TiltRow, base: TiltRow) -> ChangeRow:
    east, north = later.lean_east - base.lean_east, later.lean_north - base.lean_north
    test = _tested(later, base, east, north)
    height_m, p_value = later.height_m, test.p_value
    return ChangeRow(
        structure=later.structure,
        epoch=later.epoch,
        epoch_time=later.epoch_time,
        reference_epoch=base.epoch,
        reference_time=base.epoch_time,
        scheme=later.scheme,
        method=later.method,
        height_m=height_m,
        d_lean_east=east,
        d_lean_north=north,
        d_cov_ee=test.ee,
        d_cov_en=test.en,
        d_cov_nn=test.nn,
        d_top_m=height_m * math.hypot(east, north),
        sigma_top_m=None if test.sigma is None else height_m * test.sigma,
        chi2=test.chi2,
        p_value=p_value,
        significant=None if p_value is None else p_value < SIGNIFICANT_P,
        smallest_detectable_m=None if test.largest is None else height_m * DETECTABLE_FACTOR * test.largest,
    )


def _sum(first: float | None, second: float | None) -> float | None:
    return None if first is None or second is None else first + second
