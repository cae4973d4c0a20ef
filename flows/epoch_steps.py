"""The steps of an epoch from the isolated shaft to tilt and verdict, in the order of the paper; each asks for stages."""

from flows.epoch_work import EpochResult, EpochWork
from flows.stage_calls import Pending, artifact_of
from storage.artifacts import get_json, get_rows
from storage.records import AccuracyRow, SectionFit, TiltRow
from tasks.epoch_tables import SchemeOutcome
from tasks.exchange import plain, rebuild
from tasks.lean import Lean
from tasks.plan import PlannedAxis, plan_occasion, plan_standard
from tasks.produced import Produced
from tasks.stages import evaluate_epoch, fit_scheme_axis, slice_shaft


def measure_schemes(work: EpochWork, result: EpochResult) -> None:
    """Slice the shaft under every scheme and method, and fit the axes."""
    if result.shaft is None or result.shaft.refusal is not None:
        return
    sliced = [(axis, _ask_for_slices(work, result.shaft, axis)) for axis in work.axes]
    fitted = [
        (axis, sections, _ask_for_axis(work, result, axis, sections))
        for axis, sections in _done(work, sliced)
    ]
    result.outcomes = tuple(
        _scheme_outcome(work, axis, sections, None if pending is None else work.calls.finish(pending))
        for axis, sections, pending in fitted
    )


def evaluate_schemes(work: EpochWork, result: EpochResult) -> None:
    """Tilt, verdict and accuracy of every scheme and method that gave an axis."""
    leans = [
        {"scheme": outcome.scheme.name, "method": outcome.method.name, "lean": outcome.lean_ref.to_json()}
        for outcome in result.outcomes
        if outcome.lean_ref is not None
    ]
    if not leans:
        return
    produced = work.calls.call(
        evaluate_epoch,
        "evaluation",
        occasion=plain(plan_occasion(work.campaign, work.epoch)),
        leans=leans,
        standard=plain(plan_standard(work.campaign, work.epoch)),
    )
    if result.take_refusal("evaluation", produced):
        return
    result.tilt = tuple(get_rows(work.workspace, produced.artifacts["tilt"], TiltRow))
    result.accuracy = tuple(get_rows(work.workspace, produced.artifacts["accuracy"], AccuracyRow))


def _ask_for_slices(work: EpochWork, shaft: Produced, axis: PlannedAxis) -> Pending:
    return work.calls.submit(
        slice_shaft,
        f"slicing {axis.label}",
        shaft={name: artifact_of(shaft, name) for name in ("points", "model")},
        scheme=plain(axis.scheme),
        method=plain(axis.method),
        shaft_z_m=plain(work.campaign.structure.shaft_z_m),
    )


def _done(work: EpochWork, sliced: list[tuple[PlannedAxis, Pending]]) -> list[tuple[PlannedAxis, Produced]]:
    return [(axis, work.calls.finish(pending)) for axis, pending in sliced]


def _ask_for_axis(
    work: EpochWork, result: EpochResult, axis: PlannedAxis, sections: Produced
) -> Pending | None:
    if sections.refusal is not None or result.shaft is None:
        return None
    return work.calls.submit(
        fit_scheme_axis,
        f"axis {axis.label}",
        sections=artifact_of(sections, "sections"),
        method=plain(axis.method),
        registration=artifact_of(result.registration, "registration"),
        shaft={"model": artifact_of(result.shaft, "model"), "shares": result.shaft.facts["shares"]},
    )


def _scheme_outcome(
    work: EpochWork, axis: PlannedAxis, sections: Produced, fitted: Produced | None
) -> SchemeOutcome:
    if fitted is None:
        return SchemeOutcome(axis.scheme, axis.method, (), None, sections.refusal)
    rows = tuple(get_rows(work.workspace, sections.artifacts["sections"], SectionFit))
    if fitted.refusal is not None:
        return SchemeOutcome(axis.scheme, axis.method, rows, None, fitted.refusal)
    ref = fitted.artifacts["lean"]
    return SchemeOutcome(
        axis.scheme, axis.method, rows, rebuild(Lean, get_json(work.workspace, ref)), None, ref
    )
