"""The row of the tilt table: everything that is told of one axis."""

from dataclasses import asdict, dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from storage.records import TiltRow
from tasks.axis import Axis
from tasks.geometry.plane_vectors import DETECTABLE_FACTOR
from tasks.lean import Lean
from tasks.limits import LimitTable, MissingLimit, verdict
from tasks.tilt import TiltParameters, tilt_parameters


@dataclass(frozen=True, slots=True)
class RowHome:
    """What a row belongs to; ``epoch_time`` is ISO 8601 with an offset."""

    structure: str
    epoch: str
    epoch_time: str
    scheme: str
    method: str


@dataclass(frozen=True, slots=True)
class _Covariances:
    lean_cov_ee: float
    lean_cov_en: float
    lean_cov_nn: float
    point_cov_ee: float
    point_cov_en: float
    point_cov_nn: float
    form_cov_ee: float
    form_cov_en: float
    form_cov_nn: float
    propagated_cov_ee: float
    propagated_cov_en: float
    propagated_cov_nn: float
    jackknife_cov_ee: float | None
    jackknife_cov_en: float | None
    jackknife_cov_nn: float | None
    bootstrap_cov_ee: float | None
    bootstrap_cov_en: float | None
    bootstrap_cov_nn: float | None


@dataclass(frozen=True, slots=True)
class _Form:
    axis_model: str | None = None
    axis_reason: str | None = None
    base_lean_east: float | None = None
    base_lean_north: float | None = None
    base_lean_sigma: float | None = None
    chord_lean_east: float | None = None
    chord_lean_north: float | None = None


def tilt_row(home: RowHome, lean: Lean, height_m: float, limit: LimitTable | MissingLimit | None) -> TiltRow:
    """Make the row of an axis, judged by a limit at a height, metres."""
    axis = lean.axis
    figures = tilt_parameters(lean.lean, lean.covariance, height_m)
    judged = verdict(figures.deviation_m, figures.deviation_sigma_m, height_m, limit)
    base = axis.point_m[:2] - lean.lean * axis.point_m[2]
    return TiltRow(
        structure=home.structure,
        epoch=home.epoch,
        epoch_time=datetime.fromisoformat(home.epoch_time),
        scheme=home.scheme,
        method=home.method,
        n_slices=lean.n_slices,
        n_centres=lean.n_centres,
        base_east_m=float(base[0]),
        base_north_m=float(base[1]),
        lean_east=float(lean.lean[0]),
        lean_north=float(lean.lean[1]),
        height_m=height_m,
        **asdict(figures),
        allowable_m=judged.allowable_m,
        verdict=judged.verdict,
        verdict_reason=judged.reason,
        iterations=axis.iterations,
        update_weight_ratio_pct=axis.update_weight_ratio_pct,
        n_effective=axis.n_effective,
        mean_deviation_m=axis.mean_deviation_m,
        rmse_m=axis.rmse_m,
        bending_m=axis.bending_m,
        covariance_source=lean.source,
        **asdict(_covariances_of(lean)),
        smallest_detectable_m=_smallest_detectable_m(lean.covariance, height_m),
        cone_factor=lean.cone_factor,
        base_sigma_m=_component_sigma(lean.base_covariance),
        warning=_warning(lean, figures),
        **asdict(_form_of(axis)),
    )


def _warning(lean: Lean, figures: TiltParameters) -> str | None:
    """What to mind before signing, in one clause each."""
    said = [lean.axis.warning]
    if figures.azimuth_deg is None:
        said.append("the lean is below 3 sigma: its direction is not significant")
    if lean.source == "jackknife" and lean.misfit_p is not None:
        said.append(
            f"the stations disagree more than their stated errors allow (p = {lean.misfit_p:.2g}): the covariance is"
            " that of leaving one out after the other"
        )
    return "; ".join(filter(None, said)) or None


def _covariances_of(lean: Lean) -> _Covariances:
    return _Covariances(
        *_three(lean.covariance),
        *_three(lean.point_covariance),
        *_three(lean.form_covariance),
        *_three(lean.propagated),
        *_maybe(lean.jackknife),
        *_maybe(lean.bootstrap),
    )


def _three(covariance: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])


def _maybe(covariance: NDArray[np.float64] | None) -> tuple[float | None, float | None, float | None]:
    return (None, None, None) if covariance is None else _three(covariance)


def _component_sigma(covariance: NDArray[np.float64] | None) -> float | None:
    """Standard deviation of one component, root mean square of both; None where it is not known."""
    return None if covariance is None else float(np.sqrt(np.trace(covariance) / 2.0))


def _smallest_detectable_m(covariance: NDArray[np.float64], height_m: float) -> float:
    """Movement of the top that shows against an epoch with the same covariance, in the least certain direction."""
    worst = float(np.linalg.eigvalsh(2.0 * covariance)[-1])
    return height_m * DETECTABLE_FACTOR * float(np.sqrt(max(worst, 0.0)))


def _form_of(axis: Axis) -> _Form:
    curve = axis.curve
    if curve is None:
        return _Form()
    return _Form(
        axis_model=curve.model,
        axis_reason=curve.reason,
        base_lean_east=float(curve.base_lean[0]),
        base_lean_north=float(curve.base_lean[1]),
        base_lean_sigma=curve.base_lean_sigma,
        chord_lean_east=float(curve.chord_lean[0]),
        chord_lean_north=float(curve.chord_lean[1]),
    )
