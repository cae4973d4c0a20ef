"""A campaign: every epoch that is asked for, one after the other, and the catalog over all of them.

Called by the command line, by a notebook, or by a worker from a deployment (infra/prefect.yaml).
"""

import os
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from prefect import Flow, flow, get_run_logger
from prefect.runtime import deployment
from prefect.task_runners import ThreadPoolTaskRunner

from flows.ledger import RunLedger, StageEvent, current_ledger, new_run_id
from flows.monitor_epoch import PLAIN_JSON, monitor_epoch
from flows.outcome import EpochOutcome, EpochsFailedError
from flows.progress import STARTED, stage_line
from storage.catalog import rebuild_catalog
from storage.errors import InputError, StorageError
from storage.ledger import append_run
from storage.workspace import Workspace, open_workspace
from tasks.settings import Campaign, load_campaign

EpochFlow = Flow[[str, str, str, list[str]], EpochOutcome]

CATALOG_EVERY_S: Final = 20.0
"""In a long run the catalog follows the epochs at least this often; at the end it always does."""


@flow(name="monitor-campaign", persist_result=False, result_serializer=PLAIN_JSON)
def monitor_campaign(
    campaign_file: str, workspace: str, epochs: list[str] | None = None, schemes: list[str] | None = None
) -> list[EpochOutcome]:
    """Process the epochs of a campaign; one that fails does not stop the others.

    Raises
    ------
    InputError
        If the campaign file is bad, or an epoch or scheme is not known.
    StorageError
        If the workspace cannot be used.
    EpochsFailedError
        In a run of a deployment, where the state of the run is all that anyone sees: if any epoch failed.
    """
    campaign = load_campaign(Path(campaign_file))
    place = open_workspace(Path(workspace))
    chosen = _chosen_epochs(campaign, campaign_file, epochs or [])
    catalog = _Catalog(place)
    epoch_flow = _epoch_flow(campaign, place)
    outcomes: list[EpochOutcome] = []
    with _ledger(campaign) as ledger:
        try:
            for epoch in chosen:
                outcomes.append(_process(epoch_flow, campaign_file, place, epoch, schemes or []))
                catalog.follow()
        finally:
            append_run(place, ledger.run, ledger.structure, ledger.rows)
            rebuild_catalog(place)
    if deployment.id is not None:
        _tell_deployment(outcomes)
    return outcomes


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
    except (InputError, StorageError) as fault:
        return EpochOutcome(epoch, "failed", (str(fault),), bad_input=True)
    except Exception as fault:
        reason = f"fault of the program: {type(fault).__name__}: {fault}"
        return EpochOutcome(epoch, "failed", (reason,), bad_input=False, fault=traceback.format_exc())


def _chosen_epochs(campaign: Campaign, campaign_file: str, names: list[str]) -> list[str]:
    known = [epoch.id for epoch in sorted(campaign.epochs, key=lambda epoch: epoch.time)]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise InputError(f"{campaign_file}: no epoch {unknown[0]!r}; known: {', '.join(known)}")
    return [name for name in known if not names or name in names]


@contextmanager
def _ledger(campaign: Campaign) -> Iterator[RunLedger]:
    """The ledger of the run that called, or one of this call alone where a notebook or a deployment calls."""
    ledger = current_ledger.get(None)
    if ledger is not None:
        yield ledger
        return
    ledger = RunLedger(new_run_id(), campaign.structure.id, _log_stage)
    token = current_ledger.set(ledger)
    try:
        yield ledger
    finally:
        current_ledger.reset(token)


def _log_stage(event: StageEvent) -> None:
    if event.state != STARTED:
        get_run_logger().info("%s", stage_line(event))


def _tell_deployment(outcomes: list[EpochOutcome]) -> None:
    """Log how every epoch ended; fail the run where one did."""
    for outcome in outcomes:
        words = "; ".join((*outcome.reasons, *outcome.notes))
        get_run_logger().info("%s: %s%s", outcome.epoch, outcome.state, f": {words}" if words else "")
    failed = [outcome for outcome in outcomes if outcome.fault or outcome.bad_input]
    if failed:
        told = "; ".join(f"{outcome.epoch}: {', '.join(outcome.reasons)}" for outcome in failed)
        raise EpochsFailedError(f"{len(failed)} of {len(outcomes)} epochs failed: {told}")


@dataclass(slots=True)
class _Catalog:
    """Rebuilds the catalog now and then while epochs are published."""

    workspace: Workspace
    built_at: float = 0.0

    def follow(self) -> None:
        """Rebuild it if it is time; where it cannot be swapped just now, the end of the run tells."""
        now = time.monotonic()
        if now - self.built_at > CATALOG_EVERY_S:
            # on Windows a reader may hold the old one open: no reason to stop the epochs that are left
            with suppress(StorageError):
                rebuild_catalog(self.workspace)
            self.built_at = time.monotonic()
