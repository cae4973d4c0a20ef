"""The steps of an epoch from the isolated shaft to tilt and verdict, in the order of the paper; each asks for stages."""

from typing import cast

from flows.epoch_work import EpochResult, EpochWork
from flows.stage_calls import Pending, artifact_of
from storage.artifacts import get_json, get_rows
from storage.records import AccuracyRow, SectionFit, TiltRow
from tasks.epoch_tables import SchemeOutcome
from tasks.exchange import plain, rebuild
from tasks.lean import Lean
from tasks.plan import PlannedAxis, plan_occasion, plan_sight_noise, plan_standard, plan_surface
from tasks.produced import Json, Produced
from tasks.stages import evaluate_epoch, fit_scheme_axis, fit_whole_surface, slice_shaft


def measure_schemes(work: EpochWork, result: EpochResult) -> None:
    """Measure the shaft under every scheme and method: by slices and their axis, or by its whole surface."""
    if result.shaft is None or result.shaft.refusal is not None:
        return
    # a whole surface takes longest: it begins first and is waited for last, beside all slices and their axes
    longest_first = sorted(work.axes, key=_is_sliced)
    begun = [(axis, _ask_for_scheme(work, result, result.shaft, axis)) for axis in longest_first]
    fitted = []
    for axis, pending in sorted(begun, key=lambda each: not _is_sliced(each[0])):
        found = work.calls.finish(pending)
        fitted.append((axis, found, _ask_for_axis(work, result, axis, found)))
    outcomes = {
        axis.label: _scheme_outcome(work, axis, found, found if asked is None else work.calls.finish(asked))
        for axis, found, asked in fitted
    }
    result.outcomes = tuple(outcomes[axis.label] for axis in work.axes)


def _is_sliced(axis: PlannedAxis) -> bool:
    return axis.scheme.surface is None


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


def _ask_for_scheme(work: EpochWork, result: EpochResult, shaft: Produced, axis: PlannedAxis) -> Pending:
    if axis.scheme.surface is not None:
        return _ask_for_surface(work, result, shaft, axis)
    return _ask_for_slices(work, result, shaft, axis)


def _ask_for_surface(work: EpochWork, result: EpochResult, shaft: Produced, axis: PlannedAxis) -> Pending:
    return work.calls.submit(
        fit_whole_surface,
        f"surface {axis.label}",
        shaft=_points_of(shaft),
        registration=artifact_of(result.registration, "registration"),
        question=plain(plan_surface(work.campaign, axis)),
    )


def _ask_for_slices(work: EpochWork, result: EpochResult, shaft: Produced, axis: PlannedAxis) -> Pending:
    noise = plan_sight_noise(work.campaign, work.epoch, axis)
    sights = None
    if noise is not None:
        sights = {"registration": artifact_of(result.registration, "registration"), "noise": plain(noise)}
    return work.calls.submit(
        slice_shaft,
        f"slicing {axis.label}",
        shaft={**_points_of(shaft), "n_stations": len(cast("list[Json]", shaft.facts["shares"]))},
        sights=sights,
        scheme=plain(axis.scheme),
        method=plain(axis.method),
        shaft_z_m=plain(work.campaign.structure.shaft_z_m),
    )


def _points_of(shaft: Produced) -> dict[str, Json]:
    return {name: artifact_of(shaft, name) for name in ("points", "stations", "model")}


def _ask_for_axis(work: EpochWork, result: EpochResult, axis: PlannedAxis, found: Produced) -> Pending | None:
    """Ask for the axis of slices; None where a whole surface gave it, or the slices were refused."""
    if axis.scheme.surface is not None or found.refusal is not None:
        return None
    return work.calls.submit(
        fit_scheme_axis,
        f"axis {axis.label}",
        slices={name: artifact_of(found, name) for name in ("sections", "stations")},
        method=plain(axis.method),
        registration=artifact_of(result.registration, "registration"),
        model=artifact_of(result.shaft, "model"),
        round_cut=work.campaign.structure.sections,
    )


def _scheme_outcome(work: EpochWork, axis: PlannedAxis, found: Produced, fitted: Produced) -> SchemeOutcome:
    if found.refusal is not None:
        return SchemeOutcome(axis.scheme, axis.method, (), None, found.refusal)
    rows = tuple(get_rows(work.workspace, found.artifacts["sections"], SectionFit))
    if fitted.refusal is not None:
        return SchemeOutcome(axis.scheme, axis.method, rows, None, fitted.refusal)
    ref = fitted.artifacts["lean"]
    return SchemeOutcome(
        axis.scheme, axis.method, rows, rebuild(Lean, get_json(work.workspace, ref)), None, ref
    )
