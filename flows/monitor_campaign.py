"""A campaign: every epoch that is asked for, one after the other, and the catalog over all of them."""

import os
import time
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from prefect import Flow, flow
from prefect.task_runners import ThreadPoolTaskRunner

from flows.ledger import RunLedger, current_ledger, new_run_id
from flows.monitor_epoch import monitor_epoch
from flows.outcome import EpochOutcome
from storage.catalog import rebuild_catalog
from storage.errors import InputError, TiltwatchError
from storage.ledger import append_run
from storage.workspace import Workspace, open_workspace
from tasks.settings import Campaign, load_campaign

EpochFlow = Flow[[str, str, str, list[str]], EpochOutcome]

CATALOG_EVERY_S: Final = 20.0
"""In a long run the catalog follows the epochs at least this often; at the end it always does."""


@flow(name="monitor-campaign", persist_result=False)
def monitor_campaign(
    campaign_file: str, workspace: str, epochs: list[str] | None = None, schemes: list[str] | None = None
) -> list[EpochOutcome]:
    """Process the epochs of a campaign; one that fails does not stop the others."""
    campaign = load_campaign(Path(campaign_file))
    place = open_workspace(Path(workspace))
    ledger = _ledger(campaign)
    chosen = _chosen_epochs(campaign, campaign_file, epochs or [])
    catalog = _Catalog(place)
    epoch_flow = _epoch_flow(campaign, place)
    try:
        outcomes = []
        for epoch in chosen:
            outcomes.append(_process(epoch_flow, campaign_file, place, epoch, schemes or []))
            catalog.follow()
        return outcomes
    finally:
        append_run(place, ledger.run, ledger.structure, ledger.rows)
        rebuild_catalog(place)


def _epoch_flow(campaign: Campaign, workspace: Workspace) -> EpochFlow:
    """The flow of an epoch, with its records in the workspace and no more stages at once than asked for."""
    workers = campaign.execution.workers or os.cpu_count() or 1
    return monitor_epoch.with_options(
        result_storage=workspace.records,
        persist_result=False,
        task_runner=ThreadPoolTaskRunner(max_workers=workers),  # type: ignore[arg-type]
    )


def _process(
    epoch_flow: EpochFlow, campaign_file: str, workspace: Workspace, epoch: str, schemes: list[str]
) -> EpochOutcome:
    try:
        return epoch_flow(campaign_file, str(workspace.root), epoch, schemes)
    except TiltwatchError as fault:
        return EpochOutcome(epoch, "failed", (str(fault),), bad_input=isinstance(fault, InputError))
    except Exception as fault:
        reason = f"fault of the program: {type(fault).__name__}: {fault}"
        return EpochOutcome(epoch, "failed", (reason,), bad_input=False, fault=traceback.format_exc())


def _chosen_epochs(campaign: Campaign, campaign_file: str, names: list[str]) -> list[str]:
    known = [epoch.id for epoch in sorted(campaign.epochs, key=lambda epoch: epoch.time)]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise InputError(f"{campaign_file}: no epoch {unknown[0]!r}; known: {', '.join(known)}")
    return [name for name in known if not names or name in names]


def _ledger(campaign: Campaign) -> RunLedger:
    """The ledger of the run that called, or one of its own where a deployment calls."""
    ledger = current_ledger.get(None)
    if ledger is None:
        ledger = RunLedger(new_run_id(), campaign.structure.id, lambda _event: None)
        current_ledger.set(ledger)
    return ledger


@dataclass(slots=True)
class _Catalog:
    """Rebuilds the catalog now and then while epochs are published."""

    workspace: Workspace
    built_at: float = 0.0

    def follow(self) -> None:
        now = time.monotonic()
        if now - self.built_at > CATALOG_EVERY_S:
            rebuild_catalog(self.workspace)
            self.built_at = time.monotonic()
