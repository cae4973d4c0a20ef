"""The flow of one epoch: its method (flows/epoch_method.py) with stages that Prefect runs and caches."""

from pathlib import Path

from prefect import flow

from flows.campaign_read import read_campaign
from flows.epoch_method import process_epoch_of
from flows.epoch_work import EpochWork
from flows.ledger import current_ledger
from flows.outcome import EpochOutcome
from flows.stage_calls import StageCalls
from flows.stage_records import PLAIN_JSON
from flows.stage_tasks import FlowStages
from storage.errors import InputError, UsageError
from storage.places import with_store
from storage.workspace import Workspace
from tasks.plan import plan_axes


# Prefect stores the exception of a failed flow whatever persist_result says; this way never as a pickle
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
    return process_epoch_of(_begin(campaign_file, workspace, epoch, schemes))


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
    calls = StageCalls(ledger, epoch, place.place, FlowStages())
    axes = tuple(plan_axes(campaign, schemes))
    return EpochWork(campaign, chosen, place, calls, axes, partial=bool(schemes))
