"""The schemes, methods and reference measurements of an epoch beside each other, and how many slices are enough."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.records import ReferenceLeanRow, SchemeComparisonRow, SliceRow, TiltRow
from tasks.accuracy import Judged, LeanDifference, SchemeSigma, best_of, judge_slices, recommended_of
from tasks.compared_axes import (
    SURFACE,
    ComparedAxis,
    Shared,
    axis_of_reference,
    axis_of_scheme,
    difference_of,
)
from tasks.geometry.failure import FitFailure


@dataclass(frozen=True, slots=True)
class EpochAxes:
    """All axes of one epoch: those of its schemes and methods, with their slices, and the reference measurements."""

    structure: str
    epoch: str
    tilt: Sequence[TiltRow]
    slices: Sequence[SliceRow]
    references: Sequence[ReferenceLeanRow]


def compare_schemes(axes: EpochAxes, against: str) -> list[SchemeComparisonRow]:
    """Compare every scheme and method of one epoch, and every reference measurement, with one of them.

    Parameters
    ----------
    axes : EpochAxes
        Of one structure and epoch.
    against : str
        Scheme/method, or the source of a reference. Where it has no axis the differences are missing, with the reason.

    Returns
    -------
    list of SchemeComparisonRow
        The schemes in their order, then the references; the row of ``against`` itself has no difference.
    """
    schemes = [axis_of_scheme(row, _slices_of(row, axes.slices)) for row in axes.tilt]
    compared = [*schemes, *(axis_of_reference(row) for row in axes.references)]
    base = next((axis for axis in compared if axis.label == against), None)
    frame = _Frame(axes.structure, axes.epoch, against, base, _advice(schemes))
    return [_row(frame, axis) for axis in compared]


def labels_of(axes: EpochAxes) -> list[str]:
    """What may be compared: scheme/method of every axis, then the sources of the references."""
    return [*(f"{row.scheme}/{row.method}" for row in axes.tilt), *(row.source for row in axes.references)]


@dataclass(frozen=True, slots=True)
class _Advice:
    """Which axis is the best, what is said of each, and which scheme is recommended; None where nothing can be said."""

    best: str | None
    judged: Mapping[str, Judged]
    recommended: str | None


@dataclass(frozen=True, slots=True)
class _Frame:
    """Where the rows belong, and what they are compared with; ``base`` is None where that has no axis."""

    structure: str
    epoch: str
    against: str
    base: ComparedAxis | None
    advice: _Advice


@dataclass(frozen=True, slots=True)
class _Difference:
    """Difference from the base and what is shared with it."""

    test: LeanDifference
    shared: Shared


def _slices_of(row: TiltRow, slices: Sequence[SliceRow]) -> list[SliceRow]:
    return [s for s in slices if (s.scheme, s.method) == (row.scheme, row.method)]


def _advice(schemes: Sequence[ComparedAxis]) -> _Advice:
    sigmas = {axis.label: sigma for axis in schemes if (sigma := _sigma_of(axis)) is not None}
    best = best_of(list(sigmas.values()))
    if isinstance(best, FitFailure):
        return _Advice(None, {}, None)
    known = {axis.label: axis for axis in schemes}
    judged = {
        label: judge_slices(sigma, best, difference_of(known[label], known[best.label])[0].significant)
        for label, sigma in sigmas.items()
    }
    recommended = recommended_of(list(sigmas.values()), list(judged.values()))
    return _Advice(best.label, judged, None if isinstance(recommended, FitFailure) else recommended)


def _sigma_of(axis: ComparedAxis) -> SchemeSigma | None:
    sigma_m, row = _component_sigma_m(axis, axis.covariance), axis.tilt
    if sigma_m is None or sigma_m <= 0.0 or row is None:
        return None
    return SchemeSigma(axis.label, row.method, row.n_slices, row.n_centres, sigma_m)


def _row(frame: _Frame, axis: ComparedAxis) -> SchemeComparisonRow:
    row, found, judged = axis.tilt, _difference(frame, axis), frame.advice.judged.get(axis.label)
    test, height_m = found.test if found else None, axis.height_m
    ee, en, nn = test.variances if test else (None, None, None)
    return SchemeComparisonRow(
        structure=frame.structure,
        epoch=frame.epoch,
        compared=axis.label,
        scheme=row.scheme if row else None,
        method=row.method if row else None,
        against=frame.against,
        height_m=height_m,
        n_slices=row.n_slices if row else None,
        n_centres=row.n_centres if row else None,
        n_points=axis.n_points,
        workload_ratio=_workload_ratio(row, frame.base),
        sigma_m=_component_sigma_m(axis, axis.covariance),
        point_sigma_m=_component_sigma_m(axis, axis.point_covariance),
        d_lean_east=float(test.difference[0]) if test else None,
        d_lean_north=float(test.difference[1]) if test else None,
        d_cov_ee=ee,
        d_cov_en=en,
        d_cov_nn=nn,
        shared=found.shared if found else None,
        d_top_m=height_m * test.size if test else None,
        d_sigma_top_m=height_m * test.sigma if test and test.sigma is not None else None,
        chi2=test.chi2 if test else None,
        p_value=test.p_value if test else None,
        significant=test.significant if test else None,
        best=frame.advice.best,
        excess_pct=100.0 * judged.excess if judged else None,
        is_enough=judged.is_enough if judged else None,
        is_recommended=axis.label == frame.advice.recommended,
        reason=_reason(frame, axis, judged),
    )


def _difference(frame: _Frame, axis: ComparedAxis) -> _Difference | None:
    if frame.base is None or frame.base.label == axis.label:
        return None
    return _Difference(*difference_of(axis, frame.base))


def _workload_ratio(row: TiltRow | None, base: ComparedAxis | None) -> float | None:
    other = base.tilt if base is not None else None
    if row is None or other is None or SURFACE in (row.method, other.method) or other.n_slices == 0:
        return None
    return row.n_slices / other.n_slices


def _component_sigma_m(axis: ComparedAxis, covariance: NDArray[np.float64] | None) -> float | None:
    """Standard deviation of one component at the top, the root mean square of both."""
    if covariance is None:
        return None
    return axis.height_m * math.sqrt(max(float(np.trace(covariance)), 0.0) / 2.0)


def _reason(frame: _Frame, axis: ComparedAxis, judged: Judged | None) -> str | None:
    reasons = []
    if judged is not None:
        reasons.append(judged.reason)
    elif axis.tilt is not None:
        reasons.append(
            "its sigma is not known" if axis.covariance is None else "no sigma to compare with is known"
        )
    if frame.base is None:
        reasons.append(f"no difference: {frame.against} has no axis in this epoch")
    return "; ".join(reasons) or None
