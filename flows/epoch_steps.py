"""The steps of an epoch, in the order of the paper; each asks for one or more stages."""

import math
from typing import Any, cast

from flows.epoch_work import EpochResult, EpochWork, ReadScan
from flows.stage_calls import Pending
from storage.artifacts import ArtifactRef, get_json, get_rows
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.records import AccuracyRow, SectionFit, TiltRow
from tasks.conventions import ARCSEC_RAD
from tasks.epoch_tables import ScanInput, SchemeOutcome
from tasks.exchange import plain, rebuild
from tasks.lean import Lean
from tasks.level_check import LevelCheck, worst_suspect
from tasks.plan import (
    PlannedAxis,
    PlannedScan,
    plan_occasion,
    plan_options,
    plan_prior,
    plan_scans,
    plan_sigmas,
    plan_standard,
)
from tasks.produced import Json, Produced
from tasks.registration import Registration
from tasks.stages import (
    evaluate_epoch,
    fit_scheme_axis,
    ingest_scan,
    isolate_epoch_shaft,
    register_epoch,
    slice_shaft,
    take_registered,
)


def read_scans(work: EpochWork, result: EpochResult) -> None:
    """Read every scan of the epoch; one that is refused is named, and the others go on."""
    asked = [_ask_for_scan(work, plan) for plan in plan_scans(work.campaign, work.epoch)]
    first_with: dict[str, str] = {}
    scans = [_finish_scan(work, plan, digest, pending, first_with) for plan, digest, pending in asked]
    result.scans = tuple(scans)
    for scan in scans:
        if scan.input.refusal is not None:
            result.refuse(f"station {scan.input.station}: {scan.input.refusal}")
        result.notes += [f"station {scan.input.station}: {note}" for note in scan.input.notes]
        result.notes += _seen_before(work, scan)


def _seen_before(work: EpochWork, scan: ReadScan) -> list[str]:
    """Tell of a scan that another epoch of this run has, too: copied, it would say that nothing moved."""
    if scan.input.digest is None or scan.input.refusal is not None:
        return []
    here = f"station {scan.input.station} of epoch {work.epoch.id}"
    first = work.calls.ledger.scans.setdefault(scan.input.digest, here)
    return (
        []
        if first == here
        else [f"station {scan.input.station}: its scan is that of {first}; is it the right file"]
    )


def register_scans(work: EpochWork, result: EpochResult) -> None:
    """Place the scans in the site frame by one joint adjustment."""
    sigmas = plain(plan_sigmas(work.campaign))
    used = result.used
    if not used:
        result.refuse("no scan of the epoch could be read")
        return
    if used[0].plan.position_m is None:
        station = used[0].plan.station
        result.registration = work.calls.call(take_registered, "registration", station=station, sigmas=sigmas)
        return
    stations = [
        {
            "station": scan.plan.station,
            "points": _ref(scan.produced, "points"),
            "position_m": plain(scan.plan.position_m),
            "heading_rad": scan.plan.heading_rad,
        }
        for scan in used
    ]
    result.registration = work.calls.call(register_epoch, "registration", stations=stations, sigmas=sigmas)
    if _take_refusal(result, "registration", result.registration):
        return
    for diagnosis in registration_of(work, result.registration).diagnoses:
        if diagnosis.state != "ok":
            result.reasons.append(f"station {diagnosis.station} is {diagnosis.state}: {diagnosis.reason}")


def registration_of(work: EpochWork, produced: Produced) -> Registration:
    """Load the registration that the stage stored."""
    return rebuild(Registration, get_json(work.workspace, produced.artifacts["registration"]))


def isolate_shaft_of(work: EpochWork, result: EpochResult) -> None:
    """Take the shaft out of its surroundings."""
    if result.registration is None or result.registration.refusal is not None:
        return
    result.shaft = work.calls.call(
        isolate_epoch_shaft,
        "preprocessing",
        clouds=[_ref(scan.produced, "points") for scan in result.used],
        registration=_ref(result.registration, "registration"),
        prior=plain(plan_prior(work.campaign)),
        options=plain(plan_options(work.campaign)),
    )
    if not _take_refusal(result, "preprocessing", result.shaft):
        _tell_level(result, result.shaft)


def _tell_level(result: EpochResult, shaft: Produced) -> None:
    """A scanner out of level spoils the lean without any other sign: name it."""
    checks = levels_of(shaft)
    worst = worst_suspect(checks)
    if worst is None:
        return
    lean = math.hypot(checks[worst].lean_east or 0.0, checks[worst].lean_north or 0.0) / ARCSEC_RAD
    station = result.used[worst].plan.station
    result.reasons.append(
        f"station {station} is suspect: its side of the shaft leans {lean:.0f} arc seconds against the common one; "
        "check its level (compensator) and set it up again"
    )


def levels_of(shaft: Produced) -> tuple[LevelCheck, ...]:
    """The level checks of an isolated shaft, a station each."""
    return tuple(rebuild(LevelCheck, check) for check in cast("list[Json]", shaft.facts["levels"]))


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
    if _take_refusal(result, "evaluation", produced):
        return
    result.tilt = tuple(get_rows(work.workspace, produced.artifacts["tilt"], TiltRow))
    result.accuracy = tuple(get_rows(work.workspace, produced.artifacts["accuracy"], AccuracyRow))


def _ask_for_scan(work: EpochWork, plan: PlannedScan) -> tuple[PlannedScan, str, Pending | None]:
    """Ask for a scan by its digest; a file that cannot be read has none, and its reason stands instead."""
    if not plan.path.is_file():
        what = "is a folder; name the scan itself" if plan.path.is_dir() else "no such file; check the path"
        return plan, f"{plan.path}: {what} in the campaign file", None
    try:
        digest = file_sha256(plan.path)
    except StorageError as fault:
        return plan, str(fault), None
    pending = work.calls.submit(
        ingest_scan,
        f"ingest {plan.station}",
        path=str(plan.path),
        digest=digest,
        suffix=plan.path.suffix.lower(),
        request=plain(plan.request),
    )
    return plan, digest, pending


def _finish_scan(
    work: EpochWork, plan: PlannedScan, digest: str, pending: Pending | None, first_with: dict[str, str]
) -> ReadScan:
    if pending is None:
        return ReadScan(plan, ScanInput(plan.station, None, None, digest), None)
    produced = work.calls.finish(pending)
    refusal = (
        None
        if produced.refusal is None
        else f"{plan.path}: {produced.refusal.removeprefix(f'{plan.path}: ')}"
    )
    if digest in first_with and refusal is None:
        refusal = f"{plan.path}: holds the same bytes as the scan of station {first_with[digest]}; name the right file"
    first_with.setdefault(digest, plan.station)
    count = produced.facts.get("n_points")
    n_points = count if isinstance(count, int) else None
    notes = tuple(str(note) for note in cast("list[Json]", produced.facts.get("notes", [])))
    return ReadScan(plan, ScanInput(plan.station, digest, n_points, refusal, notes), produced)


def _ask_for_slices(work: EpochWork, shaft: Produced, axis: PlannedAxis) -> Pending:
    return work.calls.submit(
        slice_shaft,
        f"slicing {axis.label}",
        shaft={name: _ref(shaft, name) for name in ("points", "model")},
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
        sections=_ref(sections, "sections"),
        method=plain(axis.method),
        registration=_ref(result.registration, "registration"),
        shaft={"model": _ref(result.shaft, "model"), "shares": result.shaft.facts["shares"]},
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


def _take_refusal(result: EpochResult, stage: str, produced: Produced) -> bool:
    if produced.refusal is not None:
        result.refuse(f"{stage}: {produced.refusal}")
    return produced.refusal is not None


def _ref(produced: Produced | None, name: str) -> Any:
    ref: ArtifactRef | None = None if produced is None else produced.artifacts.get(name)
    if ref is None:
        raise StorageError(f"a stage produced no {name!r}; run again with an empty workspace")
    return ref.to_json()
