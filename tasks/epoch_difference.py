"""The difference of any two epochs of a structure, by scheme and by reference measurement, with its significance."""

import math
from dataclasses import dataclass

import numpy as np

from storage.records import ReferenceLeanRow, TiltRow
from storage.views import ChangeRow, reference_lean_rows, tilt_rows
from storage.workspace import Workspace
from tasks.accuracy import SIGNIFICANT_P, LeanDifference, lean_difference
from tasks.geometry.plane_vectors import DETECTABLE_FACTOR


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
class ReferenceChange:
    """Difference of the leans that one source measured in two epochs; as in the view ``changes``, metres at height_m."""

    source: str
    height_m: float
    d_lean_east: float
    d_lean_north: float
    d_cov: float
    d_top_m: float
    sigma_top_m: float
    p_value: float
    significant: bool
    smallest_detectable_m: float


def reference_differences(
    workspace: Workspace, structure: str, epoch: str, reference: str
) -> list[ReferenceChange]:
    """Compare two epochs as others measured them, by every source that measured both.

    The measurements of two epochs are taken as independent: their covariances add up.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    before = {row.source: row for row in reference_lean_rows(workspace, structure, reference)}
    after = reference_lean_rows(workspace, structure, epoch)
    return [_reference_change(row, base) for row in after if (base := before.get(row.source))]


def _reference_change(later: ReferenceLeanRow, base: ReferenceLeanRow) -> ReferenceChange:
    variance, height_m = later.sigma**2 + base.sigma**2, later.height_m
    east, north = later.lean_east - base.lean_east, later.lean_north - base.lean_north
    sigma = math.sqrt(variance)
    p_value = math.exp(-(east**2 + north**2) / variance / 2.0)
    return ReferenceChange(
        source=later.source,
        height_m=height_m,
        d_lean_east=east,
        d_lean_north=north,
        d_cov=variance,
        d_top_m=height_m * math.hypot(east, north),
        sigma_top_m=height_m * sigma,
        p_value=p_value,
        significant=p_value < SIGNIFICANT_P,
        smallest_detectable_m=height_m * DETECTABLE_FACTOR * sigma,
    )


def _tested(later: TiltRow, base: TiltRow) -> LeanDifference:
    ee = _sum(later.lean_cov_ee, base.lean_cov_ee)
    en = _sum(later.lean_cov_en, base.lean_cov_en)
    nn = _sum(later.lean_cov_nn, base.lean_cov_nn)
    d = np.array([later.lean_east - base.lean_east, later.lean_north - base.lean_north])
    known = ee is not None and en is not None and nn is not None
    return lean_difference(d, np.array([[ee, en], [en, nn]], dtype=np.float64) if known else None)


def _difference(later: TiltRow, base: TiltRow) -> ChangeRow:
    test = _tested(later, base)
    ee, en, nn = test.variances
    height_m = later.height_m
    return ChangeRow(
        structure=later.structure,
        epoch=later.epoch,
        epoch_time=later.epoch_time,
        reference_epoch=base.epoch,
        reference_time=base.epoch_time,
        scheme=later.scheme,
        method=later.method,
        height_m=height_m,
        d_lean_east=float(test.difference[0]),
        d_lean_north=float(test.difference[1]),
        d_cov_ee=ee,
        d_cov_en=en,
        d_cov_nn=nn,
        d_top_m=height_m * test.size,
        sigma_top_m=None if test.sigma is None else height_m * test.sigma,
        chi2=test.chi2,
        p_value=test.p_value,
        significant=test.significant,
        smallest_detectable_m=None if test.largest is None else height_m * DETECTABLE_FACTOR * test.largest,
    )


def _sum(first: float | None, second: float | None) -> float | None:
    return None if first is None or second is None else first + second
