"""The log of alarms: append only, one file an event, so that nothing that was said about an alarm is ever lost."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Final

from storage.atomic import write_atomically
from storage.errors import StorageError
from storage.locks import publish_lock
from storage.parquet import encode_rows
from storage.records import AlarmEventRow
from storage.second_copies import keep_second
from storage.tables import ALARM_EVENTS, table_path
from storage.workspace import Workspace

UNNUMBERED: Final = ""
"""Id of an event that gets its own when it is appended."""

_NUMBERED: Final = "????????T??????.??????Z-*.parquet"
"""Names of events that got their id here."""

_MOST_AT_A_TIME: Final = 9999
"""Of ids with one time: all events since a clock was years ahead count on from the last of those days."""


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
        keep_second(ws, path)


def append_alarm_events(ws: Workspace, rows: Sequence[AlarmEventRow]) -> list[AlarmEventRow]:
    """Add events in their order and return them with their ids: the time, then a number, so that ids sort by time.

    Where the clock was set back, an event keeps its time, ``happened_at``: that is what the clock said. Its id counts on
    from the one before it, so that ids sort as the events were appended. What an alarm is follows from the order of the
    ids: an acknowledgement must not come before the alarm.

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
            not_before = max(row.happened_at, _newest(ws, row.structure))
            numbered = replace(row, event=_free_id(ws, row.structure, not_before))
            append_alarm_event(ws, numbered)
            appended.append(numbered)
    return appended


def _free_id(ws: Workspace, structure: str, not_before: datetime) -> str:
    stamp = f"{not_before.astimezone(UTC):%Y%m%dT%H%M%S.%f}Z"
    folder = table_path(ws, ALARM_EVENTS, structure, stamp).parent
    taken = [int(path.name.split("-")[1].split(".")[0]) for path in folder.glob(f"{stamp}-*.parquet")]
    number = max(taken, default=-1) + 1
    if number > _MOST_AT_A_TIME:
        # a fifth digit would sort before four
        return _free_id(ws, structure, not_before + timedelta(microseconds=1))
    return f"{stamp}-{number:04d}"


def _newest(ws: Workspace, structure: str) -> datetime:
    """Time of the newest event, as the ids say it; the beginning of time where there is none."""
    folder = table_path(ws, ALARM_EVENTS, structure, "any").parent
    newest = max((path.name.split("Z-")[0] for path in folder.glob(_NUMBERED)), default=None)
    if newest is None:
        return datetime.min.replace(tzinfo=UTC)
    return datetime.strptime(newest, "%Y%m%dT%H%M%S.%f").replace(tzinfo=UTC)
