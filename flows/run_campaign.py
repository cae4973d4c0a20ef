"""Run a campaign from the command line or a notebook: Prefect prepared, every stage told, the outcome counted."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from flows.known_code import known_code
from flows.ledger import RunLedger, StageEvent, current_ledger, new_run_id
from flows.outcome import EpochOutcome, RunOutcome
from flows.prefect_home import prepare_prefect
from flows.settled_run import outcomes_of_settled_run
from storage.workspace import Workspace, open_workspace
from tasks.settings import Campaign
from tasks.settings.intake import load_with_intake


@dataclass(frozen=True, slots=True)
class RunRequest:
    """What to run: a campaign file, where to keep things, and which epochs and schemes (all where none is named)."""

    campaign_file: Path
    workspace: Path
    epochs: tuple[str, ...] = ()
    schemes: tuple[str, ...] = ()
    time_limit_s: float | None = None
    """Longest time that an epoch may take; none where missing, and then the epochs run in this process."""
    anew: bool = False
    """Compute also what is cached; in this process only."""
    only_new: bool = False
    """Look away from epochs whose scans, settings and code did not change since they were published."""


def run_campaign(request: RunRequest, on_event: Callable[[StageEvent], None]) -> RunOutcome:
    """Process what is not processed yet; ``on_event`` is told of every stage as it begins and ends.

    Raises
    ------
    InputError
        If the campaign file is bad, or an epoch or scheme is not known.
    StorageError
        If the workspace cannot be used.
    """
    campaign = load_with_intake(request.campaign_file, request.workspace)
    workspace = open_workspace(request.workspace)
    ledger = RunLedger(new_run_id(), campaign.structure.id, on_event, anew=set() if request.anew else None)
    token = current_ledger.set(ledger)
    try:
        outcomes = _without_engine(request, campaign, workspace, ledger)
        if outcomes is None:
            outcomes = _with_engine(request, campaign, workspace)
    finally:
        current_ledger.reset(token)
    return RunOutcome(
        ledger.run, workspace.root, ledger.count("computed"), ledger.count("cached"), tuple(outcomes)
    )


def _without_engine(
    request: RunRequest, campaign: Campaign, workspace: Workspace, ledger: RunLedger
) -> list[EpochOutcome] | None:
    """How the epochs ended, where none of them must be looked at."""
    if not request.only_new or request.anew or request.schemes:
        return None
    with known_code(workspace):
        file = str(request.campaign_file)
        return outcomes_of_settled_run(workspace, campaign, file, list(request.epochs), ledger)


def _with_engine(request: RunRequest, campaign: Campaign, workspace: Workspace) -> list[EpochOutcome]:
    engine = prepare_prefect(workspace, campaign.execution.keep_server_s)
    # Prefect reads its settings when it is imported; its server starts meanwhile
    from flows.monitor_campaign import monitor_campaign  # noqa: PLC0415
    from flows.run_guard import RunGuard  # noqa: PLC0415

    engine.wait()
    return monitor_campaign(
        str(request.campaign_file),
        str(workspace.root),
        list(request.epochs),
        list(request.schemes),
        None if request.time_limit_s is None else RunGuard(request.time_limit_s),
        only_new=request.only_new,
    )
