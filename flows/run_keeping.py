"""Keep the record of a run while it lasts, and put its stages into the ledger when it ends."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from prefect import tags
from prefect.runtime import deployment, flow_run

from flows.flow_run_states import server_in_use, tag_of
from flows.ledger import RunLedger
from flows.record_keeping import kept_record
from flows.recovery import settle_dead_runs
from storage.run_record import record_of_this_process
from storage.workspace import Workspace


@contextmanager
def kept_run(workspace: Workspace, ledger: RunLedger) -> Iterator[None]:
    """Keep a record of the run as long as the block lasts; its stages are in the ledger afterwards.

    Runs of this workspace that were killed are settled first. The runs of the epochs carry a tag, by which those
    that a killed run leaves behind are found.

    Raises
    ------
    StorageError
        If the workspace cannot be written.
    """
    settle_dead_runs(workspace)
    record = replace(
        record_of_this_process(ledger.run, ledger.structure, server_in_use()),
        flow_run=flow_run.id,
        deployment=deployment.id,
    )
    with kept_record(workspace, ledger, record), tags(tag_of(ledger.run)):
        yield
