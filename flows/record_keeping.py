"""The record and the journal of a run, and the ledger, which has its stages when it ends."""

from collections.abc import Iterator
from contextlib import contextmanager

from flows.cut_short import rows_of_cut_run
from flows.ledger import RunLedger
from storage.ledger import append_run
from storage.run_record import RunRecord, end_record, held_record, write_record
from storage.workspace import Workspace


@contextmanager
def kept_record(workspace: Workspace, ledger: RunLedger, record: RunRecord) -> Iterator[None]:
    """Keep a record of the run as long as the block lasts; its stages are in the ledger afterwards.

    Within a block that keeps one already, that one goes on, and its record says from now on what this one says.

    Raises
    ------
    StorageError
        If the workspace cannot be written.
    """
    if ledger.journal is not None:
        write_record(workspace, record)
        yield
        return
    with held_record(workspace, record) as journal:
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
