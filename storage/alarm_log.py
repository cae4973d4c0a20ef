"""The log of alarms: append only, one file an event, so that nothing that was said about an alarm is ever lost."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import Final

from storage.atomic import write_atomically
from storage.errors import StorageError
from storage.locks import publish_lock
from storage.parquet import encode_rows
from storage.records import AlarmEventRow
from storage.tables import ALARM_EVENTS, table_path
from storage.workspace import Workspace

UNNUMBERED: Final = ""
"""Id of an event that gets its own when it is appended."""


def append_alarm_event(ws: Workspace, row: AlarmEventRow) -> None:
    """Add an event to the log of the alarms of its structure.

    Raises
    ------
    StorageError
        If an event of that id is in the log already, or the disk refuses.
    InputError
        If an id cannot be a file name.
    """
    path = table_path(ws, ALARM_EVENTS, row.structure, row.event)
    content = encode_rows(ALARM_EVENTS, AlarmEventRow, [row])
    with publish_lock(ws):
        if path.exists():
            raise StorageError(
                f"event {row.event} of {row.structure} is in the log already, which is append only: {path}"
            )
        write_atomically(path, content)


def append_alarm_events(ws: Workspace, rows: Sequence[AlarmEventRow]) -> list[AlarmEventRow]:
    """Add events in their order and return them with their ids: the time, then a number, so that ids sort by time.

    Whoever decides by what stands in the log holds the publish lock from reading to here; a crash leaves the first
    few of the events.

    Parameters
    ----------
    rows : sequence of AlarmEventRow
        Events with ``UNNUMBERED`` in place of an id.

    Raises
    ------
    StorageError
        If the disk refuses.
    InputError
        If the id of a structure cannot be a file name.
    """
    appended = []
    with publish_lock(ws):
        for row in rows:
            numbered = replace(row, event=_free_id(ws, row.structure, row.happened_at))
            append_alarm_event(ws, numbered)
            appended.append(numbered)
    return appended


def _free_id(ws: Workspace, structure: str, happened_at: datetime) -> str:
    stamp = f"{happened_at.astimezone(UTC):%Y%m%dT%H%M%S.%f}Z"
    folder = table_path(ws, ALARM_EVENTS, structure, stamp).parent
    taken = [int(path.name.split("-")[1].split(".")[0]) for path in folder.glob(f"{stamp}-*.parquet")]
    return f"{stamp}-{max(taken, default=-1) + 1:04d}"
