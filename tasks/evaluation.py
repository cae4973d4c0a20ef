"""Evaluate an epoch: tilt, verdict and accuracy of every scheme and method that gave an axis."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from storage.records import AccuracyRow, TiltRow
from tasks.accuracy import Control, accuracy_rows, control_of_lean, control_of_scheme
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.limits import LimitTable, MissingLimit
from tasks.tilt_rows import RowHome, tilt_row


@dataclass(frozen=True, slots=True)
class ReferenceLean:
    """A lean vector that was measured by other means; ``sigma`` is that of each component."""

    source: str
    lean_east: float
    lean_north: float
    sigma: float


@dataclass(frozen=True, slots=True)
class Standard:
    """What an epoch is measured against: height of the deviation, limit, control.

    ``limit`` gives the verdict of the tilt table, None where the campaign names none; ``also`` are judged beside it.
    ``control`` is (scheme, method), or (source,) of a reference measurement.
    """

    height_m: float
    limit: LimitTable | MissingLimit | None
    control: tuple[str, ...]
    references: tuple[ReferenceLean, ...]
    also: tuple[LimitTable | MissingLimit, ...] = ()


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
    """Make the rows of an epoch."""
    tilt = tuple(
        tilt_row(
            RowHome(**asdict(occasion), scheme=named.scheme, method=named.method),
            named.lean,
            standard.height_m,
            standard.limit,
        )
        for named in leans
    )
    return Evaluation(tilt, compare_with_control(tilt, standard))


def compare_with_control(tilt: Sequence[TiltRow], standard: Standard) -> Comparison:
    """Compare the schemes of one epoch with the control, which may be one of them."""
    control = _control(tilt, standard)
    if isinstance(control, FitFailure):
        return Comparison((), control.reason)
    return Comparison(tuple(accuracy_rows(tilt, control)), None)


def _control(rows: Sequence[TiltRow], standard: Standard) -> Control | FitFailure:
    if len(standard.control) == 2:
        return control_of_scheme(rows, *standard.control)
    (source,) = standard.control
    for reference in standard.references:
        if reference.source == source:
            lean = np.array([reference.lean_east, reference.lean_north])
            return control_of_lean(source, lean, standard.height_m, reference.sigma)
    known = ", ".join(reference.source for reference in standard.references) or "none"
    return FitFailure(f"no reference measurement {source!r} in this epoch; there is: {known}")
