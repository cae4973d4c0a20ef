"""The step that lets an epoch share its frame with the reference epoch by surroundings that do not move."""

from dataclasses import replace

from flows.epoch_work import EpochResult, EpochWork
from flows.level_steps import leave_out_unlevel
from flows.placing_steps import clouds_of, isolate_shaft_of, register_scans
from flows.scan_steps import read_scans
from flows.stage_calls import artifact_of
from tasks.exchange import plain
from tasks.plan import plan_stable
from tasks.stages import take_stable_surroundings


def take_stable(work: EpochWork, result: EpochResult) -> None:
    """Take the stable surroundings out of the reference epoch, where the campaign names some.

    The reference epoch is placed as in its own run: what that computed is found in the cache.
    """
    reference = work.campaign.reference_epoch
    if not work.campaign.registration.stable or reference.id == work.epoch.id or work.epoch.registered:
        return
    if reference.registered:
        _do_without(work, result, "it is a registered cloud, without scans of stations")
        return
    calls = replace(work.calls, on_behalf=f"{reference.id} ")
    there, placed = replace(work, epoch=reference, calls=calls), EpochResult()
    for step in (read_scans, register_scans, isolate_shaft_of, leave_out_unlevel):
        step(there, placed)
    if placed.registration is None or placed.registration.refusal is not None:
        _do_without(work, result, "; ".join(placed.reasons))
        return
    produced = calls.call(
        take_stable_surroundings,
        "stable surroundings",
        clouds=clouds_of(there, placed.used, placed.registration),
        registration=artifact_of(placed.registration, "registration"),
        boxes=plain(plan_stable(work.campaign)),
    )
    if produced.refusal is not None:
        _do_without(work, result, produced.refusal)
        return
    result.stable = {name: artifact_of(produced, name) for name in produced.artifacts}


def _do_without(work: EpochWork, result: EpochResult, why: str) -> None:
    reference = work.campaign.reference_epoch.id
    result.reasons.append(
        f"no stable surroundings from the reference epoch {reference}: {why}; the epoch rests on GNSS alone"
    )
