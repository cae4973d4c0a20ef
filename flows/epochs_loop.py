"""The epochs of a campaign, one after the other in this process or on a cluster; one that fails does not stop others."""

import os
import time
import traceback
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from prefect import Flow
from prefect.task_runners import ThreadPoolTaskRunner

from flows.campaign_read import campaign_held
from flows.ledger import current_ledger
from flows.monitor_epoch import monitor_epoch
from flows.outcome import EpochOutcome
from flows.stage_records import keep_records
from storage.catalog import rebuild_catalog
from storage.errors import InputError, StorageError
from storage.places import check_store, with_store
from storage.workspace import Workspace
from tasks.settings import Campaign

EpochFlow = Flow[[str, str, str, list[str]], EpochOutcome]

CATALOG_EVERY_S: Final = 20.0
"""In a long run the catalog follows the epochs about this often; at the end it always does."""

CATALOG_SHARE: Final = 0.05
"""It takes no larger share of the time than this: one that grew large follows less often."""


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
    except (InputError, StorageError) as fault:
        return EpochOutcome(epoch, "failed", (str(fault),), bad_input=True)
    except Exception as fault:
        reason = f"fault of the program: {type(fault).__name__}: {fault}"
        return EpochOutcome(epoch, "failed", (reason,), bad_input=False, fault=traceback.format_exc())


@dataclass(slots=True)
class CatalogFollower:
    """Rebuilds the catalog now and then while epochs are published."""

    workspace: Workspace
    built_at: float = 0.0
    took_s: float = 0.0

    def follow(self) -> None:
        """Rebuild it if it is time; where it cannot be swapped just now, the end of the run tells."""
        began = time.monotonic()
        if began - self.built_at > max(CATALOG_EVERY_S, self.took_s / CATALOG_SHARE):
            # on Windows a reader may hold the old one open: no reason to stop the epochs that are left
            with suppress(StorageError):
                rebuild_catalog(self.workspace)
            self.built_at = time.monotonic()
            self.took_s = self.built_at - began
