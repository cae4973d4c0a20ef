"""A campaign: every epoch that is asked for, one after the other, and the catalog over all of them.

Called by the command line, by a notebook, or by a worker from a deployment (infra/prefect.yaml).
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from prefect import flow, get_run_logger
from prefect.runtime import deployment

from flows.assess_structure import assess_structure
from flows.epochs_in_children import process_in_children
from flows.epochs_loop import EpochsRequest, process_epochs
from flows.known_code import known_code
from flows.ledger import RunLedger, StageEvent, current_ledger, new_run_id
from flows.mending import mend_before
from flows.outcome import EpochOutcome, EpochsFailedError
from flows.progress import STARTED, stage_line
from flows.run_guard import RunGuard, guard_of, with_retries
from flows.run_keeping import kept_run
from flows.settled_epochs import chosen_epochs, scans_seen, settle_epochs, settled_outcomes
from flows.stage_records import PLAIN_JSON
from storage.catalog import rebuild_catalog
from storage.presence import held_in_place
from storage.upgrade import ready_or_new_workspace
from storage.workspace import Workspace
from tasks.settings import Campaign
from tasks.settings.intake import load_with_intake


@flow(name="monitor-campaign", persist_result=False, result_serializer=PLAIN_JSON)
def monitor_campaign(
    campaign_file: str,
    workspace: str,
    epochs: list[str] | None = None,
    schemes: list[str] | None = None,
    guard: RunGuard | None = None,
    only_new: bool | None = None,
) -> list[EpochOutcome]:
    """Process the epochs of a campaign; one that fails does not stop the others.

    Under a guard the epochs run in a process of their own, which is ended where an epoch takes too long. A
    deployed run has the guard of [schedule] where none is given; other runs have none then.

    With ``only_new`` epochs whose scans, settings and code did not change since they were published are not looked at
    again: their scans are not even read. A deployed run does so where nothing is said, other runs do not.

    Raises
    ------
    InputError
        If the campaign file is bad, or an epoch or scheme is not known.
    StorageError
        If the workspace cannot be used.
    EpochsFailedError
        In a run of a deployment, where the state of the run is all that anyone sees: if any epoch failed.
    """
    if deployment.id is not None:  # other runs did so before they came here
        mend_before(Path(workspace))
    campaign = load_with_intake(Path(campaign_file), Path(workspace))
    place = ready_or_new_workspace(Path(workspace))
    chosen = chosen_epochs(campaign, campaign_file, epochs or [])
    deployed = deployment.id is not None
    look_away = (deployed if only_new is None else only_new) and not schemes
    settled = settled_outcomes(place, campaign, chosen) if look_away else {}
    left = tuple(epoch for epoch in chosen if epoch not in settled)
    request = EpochsRequest(campaign_file, str(place.root), left, tuple(schemes or ()))
    if guard is None and deployed:
        guard = guard_of(campaign)
    with held_in_place(place.root), known_code(place), _ledger(place, campaign) as ledger:
        try:
            with kept_run(place, ledger):
                seen = scans_seen(campaign, left)
                done = _process(request, campaign, place, guard)
                if not schemes:
                    settle_epochs(place, campaign, done, seen)
                assess_structure(place, campaign)
        finally:
            rebuild_catalog(place)
    by_epoch = {**settled, **{outcome.epoch: outcome for outcome in done}}
    outcomes = [by_epoch[epoch] for epoch in chosen]
    if deployed:
        _tell_deployment(outcomes)
    return outcomes


def _process(
    request: EpochsRequest, campaign: Campaign, place: Workspace, guard: RunGuard | None
) -> list[EpochOutcome]:
    if guard is None:
        return process_epochs(request, campaign, place)
    time_limit_s = guard.time_limit_s

    def in_children(epochs: Sequence[str]) -> list[EpochOutcome]:
        return process_in_children(replace(request, epochs=tuple(epochs)), place, time_limit_s)

    return with_retries(in_children, request.epochs, guard)


@contextmanager
def _ledger(place: Workspace, campaign: Campaign) -> Iterator[RunLedger]:
    """The ledger of the run that called, or one of this call alone where a notebook or a deployment calls."""
    ledger = current_ledger.get(None)
    if ledger is not None:
        yield ledger
        return
    structure = campaign.structure.id
    ledger = RunLedger(new_run_id(place, structure), structure, _log_stage)
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
