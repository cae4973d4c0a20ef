"""A run in which no epoch is left to process: it needs no workflow engine, whose start would be all of its time."""

from flows.assess_structure import assess_structure
from flows.ledger import RunLedger
from storage.catalog import rebuild_catalog
from storage.ledger import append_run
from storage.run_record import is_unfinished, runs_on_record
from storage.workspace import Workspace
from tasks.settings import Campaign


def finish_settled_run(place: Workspace, campaign: Campaign, ledger: RunLedger) -> None:
    """Do what is left of such a run: put it into the ledger, assess the structure, raise alarms and send what is due.

    Raises
    ------
    StorageError
        If the workspace cannot be read or written.
    """
    try:
        append_run(place, ledger.run, ledger.structure, [])
        assess_structure(place, campaign)
    finally:
        rebuild_catalog(place)


def has_unfinished_runs(place: Workspace) -> bool:
    """Whether a run is under way or was killed; those that only wait for the server to be asked can wait longer."""
    return any(is_unfinished(place, run) for run in runs_on_record(place))
