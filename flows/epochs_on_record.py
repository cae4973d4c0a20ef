"""Epochs whose stages are all on record: they are read, verified and published as ever, without the workflow engine."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace

from flows.catalog_follower import CatalogFollower
from flows.epoch_method import measure_epoch
from flows.epoch_publication import publish_result
from flows.epoch_work import EpochResult, EpochWork
from flows.journal_lines import StageAsked
from flows.ledger import RunLedger, StageEvent
from flows.outcome import EpochOutcome, failed_epoch
from flows.stage_calls import StageCalls
from flows.stages_on_record import RecordedStages
from storage.locks import epoch_lock
from storage.workspace import Workspace
from tasks.plan import plan_axes
from tasks.settings import Campaign


@dataclass(frozen=True, slots=True)
class RecordedRequest:
    """A campaign and its workspace; only some schemes where any are named."""

    campaign: Campaign
    place: Workspace
    schemes: tuple[str, ...] = ()


def process_recorded(
    request: RecordedRequest, epochs: Sequence[str], ledger: RunLedger
) -> list[EpochOutcome]:
    """Process epochs one after the other, up to the first that has a stage to compute; that one is left as it was.

    Whatever is wrong with an epoch is left to the engine, too, which says so.

    Returns
    -------
    list
        Outcomes of the epochs before that one.
    """
    outcomes: list[EpochOutcome] = []
    catalog = CatalogFollower(request.place)
    for name in epochs:
        outcome = _processed(request, name, ledger)
        if outcome is None:
            break
        outcomes.append(outcome)
        ledger.ended(outcome)
        catalog.follow()
    return outcomes


def _processed(request: RecordedRequest, name: str, ledger: RunLedger) -> EpochOutcome | None:
    """How an epoch ended; None where that is for the engine."""
    campaign, place = request.campaign, request.place
    epoch = campaign.epoch(name)
    if epoch is None:
        return None
    # what the stages tell goes into the ledger when it is known that all of them are on record
    trial = RunLedger(
        ledger.run, ledger.structure, _tell_nobody, scans=dict(ledger.scans), digests=ledger.digests
    )
    calls = StageCalls(trial, name, place.place, RecordedStages())
    with ExitStack() as held:
        try:
            axes = tuple(plan_axes(campaign, list(request.schemes)))
            work = EpochWork(campaign, epoch, place, calls, axes, partial=bool(request.schemes))
            # an epoch that another run is at is for the engine, which waits for it
            held.enter_context(epoch_lock(place, campaign.structure.id, name, timeout_s=0.0))
            result = measure_epoch(work)
        except Exception:  # whatever it is, the engine meets it again and says so
            return None
        _tell(ledger, trial)
        return _published(replace(work, calls=replace(calls, ledger=ledger)), result)


def _published(work: EpochWork, result: EpochResult) -> EpochOutcome:
    try:
        return publish_result(work, result)
    except Exception as fault:
        return failed_epoch(work.epoch.id, fault)


def _tell_nobody(_event: StageEvent) -> None:
    """Tell nobody of a stage."""


def _tell(ledger: RunLedger, trial: RunLedger) -> None:
    """Put the stages of an epoch into the ledger of the run."""
    ledger.scans.update(trial.scans)
    ledger.passing |= trial.passing
    for row in trial.rows:
        ledger.begin(row.epoch, row.stage)
        ledger.asked(StageAsked(row.epoch, row.stage, row.started_at, row.cache_key, row.code_version))
        ledger.put_down(row)
