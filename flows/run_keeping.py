"""Keep the record of a run while it lasts, and put its stages into the ledger when it ends."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from prefect import tags
from prefect.runtime import deployment, flow_run

from flows.cut_short import rows_of_cut_run
from flows.flow_run_states import server_in_use, tag_of
from flows.ledger import RunLedger
from flows.recovery import settle_dead_runs
from storage.ledger import append_run
from storage.run_record import end_record, held_record, record_of_this_process
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
    with held_record(workspace, record) as journal, tags(tag_of(ledger.run)):
        ledger.journal = journal
        try:
            yield
        except BaseException as fault:
            told = f"the run was cut short: {type(fault).__name__}: {fault}".rstrip(": ")
            lines, _end = journal.lines()
            rows = rows_of_cut_run(ledger.run, ledger.structure, lines, told)
            append_run(workspace, ledger.run, ledger.structure, rows)
            end_record(workspace, ledger.run, finished=False)
            raise
        append_run(workspace, ledger.run, ledger.structure, ledger.rows)
        end_record(workspace, ledger.run, finished=True)
