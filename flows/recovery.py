"""Settle runs that were killed: what they did goes into the ledger, and no server takes them for running any more.

A run that is killed can do neither itself. So each run first settles those before it, and ``tiltwatch recover`` does
it without a run (infra/systemd), which matters where a dead run holds the only slot of a deployment.
"""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Final

import httpx
from prefect.client.orchestration import SyncPrefectClient, get_client
from prefect.client.schemas.objects import FlowRun
from prefect.exceptions import PrefectException

from flows.cut_short import rows_of_cut_run
from flows.flow_run_states import crash, runs_under_way, server_in_use
from flows.terminal import note
from storage.ledger import append_run, is_in_ledger
from storage.run_record import (
    RunRecord,
    end_record,
    journal_of,
    may_live,
    remove_record,
    runs_on_record,
    taken_from_dead,
)
from storage.workspace import Workspace

TELL_WITHIN: Final = timedelta(minutes=10)
"""So long after its own end a run may take to tell the server how it ended."""


@dataclass(frozen=True, slots=True)
class SettledRun:
    """A run that did not finish, and is settled now."""

    record: RunRecord
    crashed: tuple[str, ...]
    """Flow runs that were taken for running, and are set to Crashed."""


def settle_dead_runs(ws: Workspace) -> tuple[SettledRun, ...]:
    """Settle every run of a workspace whose process is gone; gives those that did not finish.

    Runs that are alive are left alone, and so are those that another server knows until a run on that server settles
    them; their stages are in the ledger then. It may be called at any time, by several at once.

    Raises
    ------
    StorageError
        If the workspace cannot be written.
    """
    settled = []
    for run in runs_on_record(ws):
        with taken_from_dead(ws, run) as record:
            if record is not None:
                settled += _settle(ws, record)
    return tuple(settled)


def _settle(ws: Workspace, record: RunRecord) -> list[SettledRun]:
    reason = f"the run was cut short: process {record.pid} on {record.host} is gone"
    if record.ended_at is None:
        rows = _into_ledger(ws, record, reason)
        note(f"run {record.run}: {reason}; {rows} rows of it are in the ledger")
    told = _tell_server(record, reason)
    if told is None or told.waits:
        return []
    remove_record(ws, record.run)
    return [] if record.finished else [SettledRun(record, told.crashed)]


def _into_ledger(ws: Workspace, record: RunRecord, reason: str) -> int:
    """Put what a killed run did into the ledger, once; gives the number of rows."""
    lines, _end = journal_of(ws, record.run).lines()
    rows = rows_of_cut_run(record.run, record.structure, lines, reason)
    if rows and not is_in_ledger(ws, record.run, record.structure):
        append_run(ws, record.run, record.structure, rows)
    end_record(ws, record.run, finished=False)
    return len(rows)


@dataclass(frozen=True, slots=True)
class _Told:
    crashed: tuple[str, ...]
    waits: bool
    """Whether the run may still tell the server itself."""


def _tell_server(record: RunRecord, reason: str) -> _Told | None:
    """Set what the server takes for running to Crashed; None where it cannot be asked."""
    if record.server != server_in_use():
        return None
    try:
        with get_client(sync_client=True) as client:
            return _crash_what_is_left(client, record, reason)
    except (httpx.HTTPError, PrefectException) as fault:
        note(f"run {record.run}: the workflow server did not answer ({fault}); the next run asks again")
        return None


def _crash_what_is_left(client: SyncPrefectClient, record: RunRecord, reason: str) -> _Told:
    left: list[FlowRun] = runs_under_way(client, record.run, record.flow_run)
    if left and _may_tell_itself(record):
        return _Told((), waits=True)
    crash(client, left, reason)
    return _Told(tuple(str(run.id) for run in left), waits=False)


def _may_tell_itself(record: RunRecord) -> bool:
    """Whether a run came to its own end just now, and its process is still there."""
    if record.ended_at is None or not may_live(record):
        return False
    # an end further ahead than that was told before the clock was set back
    return abs(datetime.now(UTC) - datetime.fromisoformat(record.ended_at)) < TELL_WITHIN
