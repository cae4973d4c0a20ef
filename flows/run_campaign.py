"""Run a campaign from the command line or a notebook: Prefect prepared, every stage told, the outcome counted."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from flows.early_imports import begin_imports, find_versions, keep_what_was_compiled
from flows.known_code import known_code
from flows.ledger import RunLedger, StageEvent, current_ledger, new_run_id
from flows.outcome import EpochOutcome, RunOutcome
from flows.prefect_home import check_environment, prepare_prefect, users_server
from flows.settled_epochs import chosen_epochs, settled_outcomes
from flows.settled_run import finish_settled_run, has_unfinished_runs
from flows.terminal import note
from storage.identity import is_identified
from storage.presence import held_in_place
from storage.upgrade import ready_or_new_workspace
from storage.workspace import Workspace
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


def run_campaign(
    request: RunRequest, on_event: Callable[[StageEvent], None], campaign: Campaign | None = None
) -> RunOutcome:
    """Process what is not processed yet; ``on_event`` is told of every stage as it begins and ends.

    Who has read the campaign file just now, with what came through an inbox, may hand that over.

    Raises
    ------
    InputError
        If the campaign file is bad, or an epoch or scheme is not known.
    StorageError
        If the workspace cannot be used.
    UsageError
        If a variable of the environment is none that can be used.
    """
    campaign = campaign or load_with_intake(request.campaign_file, request.workspace)
    check_environment()
    _tell_if_new(request.workspace)
    workspace = ready_or_new_workspace(request.workspace)
    ledger = _new_ledger(request, campaign, workspace, on_event)
    token = current_ledger.set(ledger)
    try:
        with held_in_place(workspace.root), known_code(workspace):
            outcomes = _outcomes(request, campaign, workspace, ledger)
    finally:
        current_ledger.reset(token)
    return RunOutcome(
        ledger.run, workspace.root, ledger.count("computed"), ledger.count("cached"), tuple(outcomes)
    )


def _new_ledger(
    request: RunRequest, campaign: Campaign, workspace: Workspace, on_event: Callable[[StageEvent], None]
) -> RunLedger:
    structure = campaign.structure.id
    return RunLedger(
        new_run_id(workspace, structure), structure, on_event, anew=set() if request.anew else None
    )


def _tell_if_new(place: Path) -> None:
    """Say that nothing was there: to who has results in a workspace, its drive may be missing."""
    if not is_identified(Workspace(place).identity):
        note(
            f"new workspace {place}; if results should be there already, end this run and look for their drive"
        )


def _outcomes(
    request: RunRequest, campaign: Campaign, workspace: Workspace, ledger: RunLedger
) -> list[EpochOutcome]:
    """How the epochs ended; the engine is started where a stage may have to be computed."""
    asked = list(request.epochs)

    def with_engine(epochs: Sequence[str]) -> list[EpochOutcome]:
        return _with_engine(replace(request, epochs=tuple(epochs)), campaign, workspace)

    if request.anew or has_unfinished_runs(workspace):
        return with_engine(asked)
    chosen = chosen_epochs(campaign, str(request.campaign_file), asked)
    settled: dict[str, EpochOutcome] = {}
    if request.only_new and not request.schemes:
        settled = settled_outcomes(workspace, campaign, chosen)
        if len(settled) == len(chosen):
            finish_settled_run(workspace, campaign)
            return [settled[epoch] for epoch in chosen]
    if not _may_be_on_record(request, campaign, workspace):
        return with_engine(asked)
    # what epochs are worked on with takes a moment to import
    from flows.epochs_on_record import RecordedRequest  # noqa: PLC0415
    from flows.recorded_run import outcomes_of_recorded_run  # noqa: PLC0415

    recorded = RecordedRequest(campaign, workspace, request.schemes)
    left = [epoch for epoch in chosen if epoch not in settled]
    done = outcomes_of_recorded_run(recorded, left, ledger, with_engine)
    by_epoch = {**settled, **{outcome.epoch: outcome for outcome in done}}
    return [by_epoch[epoch] for epoch in chosen]


def _may_be_on_record(request: RunRequest, campaign: Campaign, workspace: Workspace) -> bool:
    """Whether it is worth a look: a cluster looks itself, side by side, and a time limit wants a process that can end.

    So does a server of the user's.
    """
    execution = campaign.execution
    here = execution.engine == "local" and execution.store is None and request.time_limit_s is None
    # a server that the user named is to know of every run: what waits for its flow runs would wait in vain
    here = here and users_server() is None
    return here and workspace.records.is_dir() and any(workspace.records.iterdir())


def _with_engine(request: RunRequest, campaign: Campaign, workspace: Workspace) -> list[EpochOutcome]:
    engine = prepare_prefect(workspace, campaign.execution.keep_server_s)
    if campaign.execution.engine == "local" and request.time_limit_s is None:
        begin_imports()
    # Prefect reads its settings when it is imported; its server starts meanwhile
    from flows.monitor_campaign import monitor_campaign  # noqa: PLC0415
    from flows.quiet_engine import quiet_engine  # noqa: PLC0415
    from flows.run_guard import RunGuard  # noqa: PLC0415
    from flows.server_check import loss_told  # noqa: PLC0415

    find_versions()
    engine.wait()
    with quiet_engine(), loss_told():
        outcomes = monitor_campaign(
            str(request.campaign_file),
            str(workspace.root),
            list(request.epochs),
            list(request.schemes),
            None if request.time_limit_s is None else RunGuard(request.time_limit_s),
            only_new=request.only_new,
        )
    keep_what_was_compiled()
    return outcomes
