"""A run that takes what is on record without the workflow engine, and starts that for the epochs that are left."""

from collections.abc import Callable, Sequence

from flows.assess_structure import assess_structure
from flows.epochs_on_record import RecordedRequest, process_recorded
from flows.ledger import RunLedger
from flows.outcome import EpochOutcome
from flows.prefect_home import OWN_SERVER, users_server
from flows.record_keeping import kept_record
from flows.settled_epochs import scans_seen, settle_epochs
from storage.catalog import rebuild_catalog
from storage.run_record import record_of_this_process, remove_record

Engine = Callable[[Sequence[str]], list[EpochOutcome]]
"""Does a run for epochs: processes them, and assesses the structure."""


def outcomes_of_recorded_run(
    request: RecordedRequest, epochs: Sequence[str], ledger: RunLedger, engine: Engine
) -> list[EpochOutcome]:
    """Do a run: epochs up to the first that has a stage to compute without the engine, the others with it.

    Raises
    ------
    InputError, StorageError
        As the engine, and if the workspace cannot be read or written.
    """
    place, campaign = request.place, request.campaign
    server = users_server() or OWN_SERVER
    try:
        with kept_record(place, ledger, record_of_this_process(ledger.run, ledger.structure, server)):
            seen = scans_seen(campaign, epochs)
            done = process_recorded(request, epochs, ledger)
            if not request.schemes:
                settle_epochs(place, campaign, done, seen)
            left = epochs[len(done) :]
            if left:
                done += engine(left)
            else:
                assess_structure(place, campaign)
    finally:
        rebuild_catalog(place)
    if not left:
        # no server knows of it, so there is nobody whom a later run had to ask
        remove_record(place, ledger.run)
    return done
