"""The log of alarms: append only, one file an event, so that nothing that was said about an alarm is ever lost."""

from storage.atomic import write_atomically
from storage.errors import StorageError
from storage.locks import publish_lock
from storage.parquet import encode_rows
from storage.records import AlarmEventRow
from storage.tables import ALARM_EVENTS, table_path
from storage.workspace import Workspace


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
