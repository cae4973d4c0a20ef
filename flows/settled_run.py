"""A run in which no epoch is left to process: it needs no workflow engine, whose start would be all of its time."""

from flows.assess_structure import assess_structure
from storage.catalog import rebuild_catalog
from storage.run_record import is_unfinished, runs_on_record
from storage.workspace import Workspace
from tasks.settings import Campaign


def finish_settled_run(place: Workspace, campaign: Campaign) -> None:
    """Do what is left of such a run: assess the structure, raise alarms and send what is due.

    It asked for no stage, so the ledger has nothing of it: one that comes every hour would fill a disk with empty files.

    Raises
    ------
    StorageError
        If the workspace cannot be read or written.
    """
    try:
        assess_structure(place, campaign)
    finally:
        rebuild_catalog(place)


def has_unfinished_runs(place: Workspace) -> bool:
    """Whether a run is under way or was killed; those that only wait for the server to be asked can wait longer."""
    return any(is_unfinished(place, run) for run in runs_on_record(place))
