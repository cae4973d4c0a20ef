"""A run in which no epoch is left to process: it needs no workflow engine, whose start would be all of its time."""

from flows.assess_structure import assess_structure
from flows.ledger import RunLedger
from flows.outcome import EpochOutcome
from flows.settled_epochs import chosen_epochs, settled_outcomes
from storage.catalog import rebuild_catalog
from storage.ledger import append_run
from storage.run_record import read_record, runs_on_record
from storage.workspace import Workspace
from tasks.settings import Campaign


def outcomes_of_settled_run(
    place: Workspace, campaign: Campaign, campaign_file: str, epochs: list[str], ledger: RunLedger
) -> list[EpochOutcome] | None:
    """Do what such a run does: put it into the ledger, assess the structure, raise alarms and send what is due.

    Returns
    -------
    list or None
        How the epochs ended when they were published; None, and nothing was done, where one must be looked at, or a
        run before this one did not come to its end and is to be settled first.

    Raises
    ------
    InputError
        If an epoch is not known.
    StorageError
        If the workspace cannot be read or written.
    """
    chosen = chosen_epochs(campaign, campaign_file, epochs)
    if _has_unfinished_runs(place):
        return None
    settled = settled_outcomes(place, campaign, chosen)
    if len(settled) < len(chosen):
        return None
    try:
        append_run(place, ledger.run, ledger.structure, [])
        assess_structure(place, campaign)
    finally:
        rebuild_catalog(place)
    return [settled[epoch] for epoch in chosen]


def _has_unfinished_runs(place: Workspace) -> bool:
    """Whether a run is under way or was killed; those that only wait for the server to be asked can wait longer."""
    records = [read_record(place, run) for run in runs_on_record(place)]
    return any(record is None or record.ended_at is None for record in records)
