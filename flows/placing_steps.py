"""The steps that place the scans of an epoch in the site frame and take the shaft out of them."""

from collections.abc import Sequence
from typing import cast

from flows.epoch_work import EpochResult, EpochWork, ReadScan
from flows.stage_calls import artifact_of
from storage.artifacts import get_json
from tasks.exchange import plain, rebuild
from tasks.level_check import LevelCheck
from tasks.plan import plan_options, plan_prior, plan_shaft_hint, plan_sigmas
from tasks.produced import Json, Produced
from tasks.registration import RefusedStation, Registration
from tasks.stages import isolate_epoch_shaft, register_epoch, take_registered
from tasks.stated_pose import stated_pose


def register_scans(work: EpochWork, result: EpochResult) -> None:
    """Place the scans in the site frame by one joint adjustment; stations that do not fit are left out."""
    used = result.used
    if not used:
        result.refuse("no scan of the epoch could be read")
        return
    if used[0].plan.is_registered:
        result.registration = work.calls.call(
            take_registered,
            "registration",
            station=used[0].plan.station,
            sigmas=plain(plan_sigmas(work.campaign)),
        )
        return
    result.registration = ask_for_registration(work, used, result.stable, "registration")
    if not result.take_refusal("registration", result.registration):
        leave_out_refused(result, registration_of(work, result.registration).refused)


def isolate_shaft_of(work: EpochWork, result: EpochResult) -> None:
    """Take the shaft out of its surroundings."""
    if result.registration is None or result.registration.refusal is not None:
        return
    result.shaft = ask_for_shaft(work, result.used, result.registration, "preprocessing")
    if not result.take_refusal("preprocessing", result.shaft):
        result.levels.update(levels_of(work, result.registration, result.shaft))


def tell_suspects(work: EpochWork, result: EpochResult) -> None:
    """Tell of the stations that are used although something is wrong with them."""
    if result.registration is not None and result.registration.refusal is None:
        registration = registration_of(work, result.registration)
        result.reasons += list(registration.warnings)
        for diagnosis in registration.diagnoses:
            if diagnosis.state != "ok":
                result.reasons.append(f"station {diagnosis.station} is {diagnosis.state}: {diagnosis.reason}")
    result.reasons += [f"station {station} is suspect: {why}" for station, why in result.suspects.items()]


def ask_for_registration(work: EpochWork, scans: Sequence[ReadScan], stable: object, label: str) -> Produced:
    """Ask for the joint adjustment of some scans of stations."""
    return work.calls.call(
        register_epoch,
        label,
        stations=[_station(work, scan) for scan in scans],
        sigmas=plain(plan_sigmas(work.campaign)),
        shaft=plain(plan_shaft_hint(work.campaign)),
        stable=stable,
    )


def ask_for_shaft(work: EpochWork, scans: Sequence[ReadScan], registration: Produced, label: str) -> Produced:
    """Ask for the shaft in scans that were registered together; those that the registration left out have no part."""
    return work.calls.call(
        isolate_epoch_shaft,
        label,
        clouds=clouds_of(work, scans, registration),
        registration=artifact_of(registration, "registration"),
        prior=plain(plan_prior(work.campaign)),
        options=plain(plan_options(work.campaign)),
    )


def clouds_of(work: EpochWork, scans: Sequence[ReadScan], registration: Produced) -> list[Json]:
    """References to the points of the scans that have a pose, in the order of the poses."""
    by_station = {scan.plan.station: scan for scan in scans}
    poses = registration_of(work, registration).poses
    return [artifact_of(by_station[pose.station].produced, "points") for pose in poses]


def registration_of(work: EpochWork, produced: Produced) -> Registration:
    """Load the registration that the stage stored."""
    return rebuild(Registration, get_json(work.workspace, produced.artifacts["registration"]))


def levels_of(work: EpochWork, registration: Produced, shaft: Produced) -> dict[str, LevelCheck]:
    """Level checks of an isolated shaft by station, in the order of the poses."""
    checks = [rebuild(LevelCheck, check) for check in cast("list[Json]", shaft.facts["levels"])]
    stations = [pose.station for pose in registration_of(work, registration).poses]
    return dict(zip(stations, checks, strict=True))


def leave_out_refused(result: EpochResult, refused: Sequence[RefusedStation]) -> None:
    """Go on without the stations that the registration refused."""
    for station in refused:
        result.leave_out(station.station, station.reason)


def _station(work: EpochWork, scan: ReadScan) -> dict[str, Json]:
    facts = {} if scan.produced is None else scan.produced.facts
    pose = stated_pose(work.campaign, scan.plan, facts)
    return {
        "station": scan.plan.station,
        "points": artifact_of(scan.produced, "points"),
        "position_m": plain(pose.position_m),
        "heading_rad": pose.heading_rad,
    }
