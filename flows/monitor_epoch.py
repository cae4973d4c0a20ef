"""One epoch, from station scans to published rows, in the order of the paper's method section."""

from pathlib import Path
from typing import Final

from prefect import flow
from prefect.serializers import JSONSerializer

from flows.campaign_read import read_campaign
from flows.epoch_publication import publish_result
from flows.epoch_quality import rate_coverage_of
from flows.epoch_steps import evaluate_schemes, measure_schemes
from flows.epoch_work import EpochResult, EpochWork
from flows.ledger import current_ledger
from flows.level_steps import leave_out_unlevel
from flows.map_steps import map_surface_of
from flows.outcome import EpochOutcome
from flows.placing_steps import isolate_shaft_of, register_scans, tell_suspects
from flows.scan_steps import read_scans
from flows.stable_steps import take_stable
from flows.stage_calls import StageCalls
from storage.errors import InputError, UsageError
from storage.locks import epoch_lock
from storage.places import with_store
from storage.workspace import Workspace
from tasks.plan import plan_axes

WAIT_FOR_OTHERS_S: Final = 4 * 3600.0
"""Another run of the same epoch is waited for: what it computes is then found in the cache."""

PLAIN_JSON: Final = JSONSerializer(object_encoder=None, object_decoder=None)
"""Prefect stores the exception of a failed flow whatever ``persist_result`` says; this way never as a pickle."""


@flow(name="monitor-epoch", persist_result=False, result_serializer=PLAIN_JSON)
def monitor_epoch(campaign_file: str, workspace: str, epoch: str, schemes: list[str]) -> EpochOutcome:
    """Measure the lean of a structure in one epoch under every scheme, and publish it.

    Stages that were done before on the same input, with the same parameters and code, are taken from the
    cache. Bad input is a recorded state of the epoch, not an exception.

    It is a part of monitor_campaign, which says where the records go and keeps the ledger and the catalog;
    for one epoch alone call that with ``epochs=[epoch]``.

    Raises
    ------
    UsageError
        If monitor_campaign did not call.
    InputError
        If the campaign has no such epoch.
    """
    work = _begin(campaign_file, workspace, epoch, schemes)
    result = EpochResult()
    with epoch_lock(work.workspace, work.campaign.structure.id, epoch, timeout_s=WAIT_FOR_OTHERS_S):
        read_scans(work, result)
        take_stable(work, result)
        register_scans(work, result)
        isolate_shaft_of(work, result)
        leave_out_unlevel(work, result)
        tell_suspects(work, result)
        rate_coverage_of(work, result)
        measure_schemes(work, result)
        map_surface_of(work, result)
        evaluate_schemes(work, result)
        return publish_result(work, result)


def _begin(campaign_file: str, workspace: str, epoch: str, schemes: list[str]) -> EpochWork:
    campaign = read_campaign(campaign_file, workspace)
    chosen = campaign.epoch(epoch)
    if chosen is None:
        known = ", ".join(known.id for known in campaign.epochs)
        raise InputError(f"{campaign_file}: no epoch {epoch!r}; known: {known}")
    place = with_store(Workspace(Path(workspace)), campaign.execution.store)
    ledger = current_ledger.get(None)
    if ledger is None:
        raise UsageError(
            f"monitor_epoch needs the ledger of monitor_campaign: call monitor_campaign(..., epochs=[{epoch!r}])"
        )
    calls = StageCalls(ledger, epoch, place.place)
    axes = tuple(plan_axes(campaign, schemes))
    return EpochWork(campaign, chosen, place, calls, axes, partial=bool(schemes))
