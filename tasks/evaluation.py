"""Evaluate an epoch: tilt, verdict and accuracy of every scheme and method that gave an axis."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import datetime

import numpy as np

from storage.records import AccuracyRow, TiltRow
from tasks.accuracy import Control, accuracy_rows, control_of_lean, control_of_scheme
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.limits import LimitTable, table_named, table_of_points, verdict
from tasks.tilt import tilt_parameters


@dataclass(frozen=True, slots=True)
class ReferenceLean:
    """A lean vector that was measured by other means."""

    source: str
    lean_east: float
    lean_north: float


@dataclass(frozen=True, slots=True)
class Standard:
    """What an epoch is measured against: height of the deviation, limit, control.

    ``control`` is (scheme, method), or (source,) of a reference measurement.
    """

    height_m: float
    limit_table: str | None
    limit_points_m: tuple[tuple[float, float], ...] | None
    control: tuple[str, ...]
    references: tuple[ReferenceLean, ...]


@dataclass(frozen=True, slots=True)
class Occasion:
    """Which structure and epoch; ``epoch_time`` is ISO 8601 with an offset."""

    structure: str
    epoch: str
    epoch_time: str


@dataclass(frozen=True, slots=True)
class NamedLean:
    """A lean with the scheme and method that it comes from."""

    scheme: str
    method: str
    lean: Lean


@dataclass(frozen=True, slots=True)
class Comparison:
    """Rows of the accuracy table; ``control_missing`` says why there are none."""

    accuracy: tuple[AccuracyRow, ...]
    control_missing: str | None


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Rows of the tilt table, and what they are beside the control."""

    tilt: tuple[TiltRow, ...]
    comparison: Comparison


def evaluate(occasion: Occasion, leans: Sequence[NamedLean], standard: Standard) -> Evaluation:
    """Make the rows of an epoch.

    Raises
    ------
    InputError
        If the limit table is not known.
    """
    limit = limit_of(standard)
    tilt = tuple(_tilt_row(occasion, named, standard.height_m, limit) for named in leans)
    return Evaluation(tilt, compare_with_control(tilt, standard))


def compare_with_control(tilt: Sequence[TiltRow], standard: Standard) -> Comparison:
    """Compare the schemes of one epoch with the control, which may be one of them."""
    control = _control(tilt, standard)
    if isinstance(control, FitFailure):
        return Comparison((), control.reason)
    return Comparison(tuple(accuracy_rows(tilt, control)), None)


def limit_of(standard: Standard) -> LimitTable | None:
    """The limit of the campaign: its own points win over a shipped table; None where it has neither."""
    if standard.limit_points_m is not None:
        return table_of_points(standard.limit_points_m)
    return None if standard.limit_table is None else table_named(standard.limit_table)


def _control(rows: Sequence[TiltRow], standard: Standard) -> Control | FitFailure:
    if len(standard.control) == 2:
        return control_of_scheme(rows, *standard.control)
    (source,) = standard.control
    for reference in standard.references:
        if reference.source == source:
            lean = np.array([reference.lean_east, reference.lean_north])
            return control_of_lean(source, lean, standard.height_m)
    known = ", ".join(reference.source for reference in standard.references) or "none"
    return FitFailure(f"no reference measurement {source!r} in this epoch; there is: {known}")


def _tilt_row(occasion: Occasion, named: NamedLean, height_m: float, limit: LimitTable | None) -> TiltRow:
    lean, axis = named.lean, named.lean.axis
    figures = tilt_parameters(lean.lean, lean.covariance, height_m)
    judged = verdict(figures.deviation_m, figures.deviation_sigma_m, height_m, limit)
    base = axis.point_m[:2] - lean.lean * axis.point_m[2]
    return TiltRow(
        structure=occasion.structure,
        epoch=occasion.epoch,
        epoch_time=datetime.fromisoformat(occasion.epoch_time),
        scheme=named.scheme,
        method=named.method,
        n_slices=lean.n_slices,
        n_centres=lean.n_centres,
        base_east_m=float(base[0]),
        base_north_m=float(base[1]),
        lean_east=float(lean.lean[0]),
        lean_north=float(lean.lean[1]),
        lean_cov_ee=float(lean.covariance[0, 0]),
        lean_cov_en=float(lean.covariance[0, 1]),
        lean_cov_nn=float(lean.covariance[1, 1]),
        point_cov_ee=float(lean.point_covariance[0, 0]),
        point_cov_en=float(lean.point_covariance[0, 1]),
        point_cov_nn=float(lean.point_covariance[1, 1]),
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
    )
