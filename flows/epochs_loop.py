"""The epochs of a campaign, one after the other in this process or on a cluster; one that fails does not stop others."""

import os
from dataclasses import dataclass
from typing import Any

from prefect import Flow
from prefect.task_runners import ThreadPoolTaskRunner

from flows.campaign_read import campaign_held
from flows.catalog_follower import CatalogFollower
from flows.ledger import current_ledger
from flows.monitor_epoch import monitor_epoch
from flows.outcome import EpochOutcome, failed_epoch
from flows.stage_records import keep_records
from storage.places import check_store, with_store
from storage.workspace import Workspace
from tasks.memory_room import allow_memory
from tasks.settings import Campaign

EpochFlow = Flow[[str, str, str, list[str]], EpochOutcome]


@dataclass(frozen=True, slots=True)
class EpochsRequest:
    """Which epochs and schemes of a campaign to process; all schemes where none is named."""

    campaign_file: str
    workspace: str
    epochs: tuple[str, ...]
    schemes: tuple[str, ...] = ()


def process_epochs(request: EpochsRequest, campaign: Campaign, place: Workspace) -> list[EpochOutcome]:
    """Process epochs with the engine of the campaign; needs the ledger of a run in ``current_ledger``.

    The catalog follows them.

    Raises
    ------
    StorageError
        If the store of the campaign cannot be used.
    InputError, UsageError
        If its cluster cannot be used.
    """
    place = with_store(place, campaign.execution.store)
    if place.store is not None:
        check_store(place.store)
    if campaign.execution.engine == "dask":
        # it needs this module
        from flows.epochs_on_dask import process_on_dask  # noqa: PLC0415

        return process_on_dask(request, campaign, place)
    return _process_here(request, campaign, place)


def _process_here(request: EpochsRequest, campaign: Campaign, place: Workspace) -> list[EpochOutcome]:
    ledger = current_ledger.get()
    catalog = CatalogFollower(place)
    allow_memory(campaign.execution.memory_gb)
    epoch_flow = _epoch_flow(campaign, place)
    outcomes: list[EpochOutcome] = []
    with campaign_held(request.campaign_file, request.workspace, campaign):
        for epoch in request.epochs:
            outcomes.append(process_epoch(epoch_flow, request, epoch))
            ledger.ended(outcomes[-1])
            catalog.follow()
    return outcomes


def _epoch_flow(campaign: Campaign, workspace: Workspace) -> EpochFlow:
    """The flow of an epoch, with its records in the workspace and no more stages at once than asked for."""
    workers = campaign.execution.workers or os.cpu_count() or 1
    runner: ThreadPoolTaskRunner[Any] = ThreadPoolTaskRunner(max_workers=workers)
    made = monitor_epoch.with_options(persist_result=False, task_runner=runner)  # type: ignore[arg-type]
    return keep_records(made, workspace)


def process_epoch(epoch_flow: EpochFlow, request: EpochsRequest, epoch: str) -> EpochOutcome:
    """Process one epoch; whatever is wrong with it is told in its outcome."""
    try:
        return epoch_flow(request.campaign_file, request.workspace, epoch, list(request.schemes))
    except Exception as fault:
        return failed_epoch(epoch, fault)
