"""The log of alarms: ids in the order of time, events that never change, and the view that follows from them."""

import threading
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest

from storage import views
from storage.alarm_log import UNNUMBERED, append_alarm_event, append_alarm_events
from storage.catalog import rebuild_catalog
from storage.errors import StorageError
from storage.ids import check_id
from storage.locks import delivery_lock
from storage.records import AlarmEventRow, AlarmRow
from storage.workspace import Workspace, open_workspace
from tasks.alarms.history import alarms_of
from tests.storage.campaign import STRUCTURE, alarm_event_row, epoch_time


@pytest.fixture
def ws(tmp_path: Path) -> Workspace:
    return open_workspace(tmp_path / "ws")


def event(action: str, minutes: int, **changed: object) -> AlarmEventRow:
    row = alarm_event_row(UNNUMBERED, action)
    return replace(row, happened_at=epoch_time(0) + timedelta(minutes=minutes), **changed)


def view_of(ws: Workspace, *events: AlarmEventRow) -> AlarmRow:
    append_alarm_events(ws, events)
    rebuild_catalog(ws)
    (alarm,) = views.alarm_rows(ws, STRUCTURE)
    return alarm


def test_ids_sort_as_they_were_appended_and_are_safe_file_names(ws: Workspace) -> None:
    rows = append_alarm_events(ws, [event("raised", 5), event("updated", 5), event("raised", 3)])
    assert sorted(row.event for row in rows) == [row.event for row in rows]
    assert [check_id(row.event, "an event") for row in rows]
    assert [row.event for row in views.rows_of(ws, AlarmEventRow)] == sorted(row.event for row in rows)


def test_an_id_is_never_used_twice_whoever_appends(ws: Workspace) -> None:
    threads = [
        threading.Thread(target=append_alarm_events, args=(ws, [event("raised", 0)] * 3)) for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60.0)
    assert len({row.event for row in views.rows_of(ws, AlarmEventRow)}) == 9


def test_state_follows_from_the_deeds(ws: Workspace) -> None:
    assert view_of(ws, event("raised", 0)).state == "new"
    assert view_of(ws, event("acknowledged", 1)).state == "acknowledged"
    assert view_of(ws, event("muted", 2, until=epoch_time(9))).state == "muted"
    assert view_of(ws, event("updated", 3, person=None)).state == "muted"
    assert view_of(ws, event("unmuted", 4)).state == "acknowledged"
    assert view_of(ws, event("eased", 5, person=None)).state == "acknowledged"
    assert view_of(ws, event("closed", 6)).state == "closed"
    assert view_of(ws, event("updated", 7, person=None)).state == "closed"


def test_a_graver_alarm_is_new_again(ws: Workspace) -> None:
    events = [event("raised", 0), event("acknowledged", 1), event("updated", 2, severity="alarm")]
    assert view_of(ws, *events).state == "new"


def test_value_and_epoch_are_what_the_rule_found_last_and_the_rest_what_people_said(ws: Workspace) -> None:
    alarm = view_of(
        ws,
        event("raised", 0, unit="m", note="21 mm", person=None),
        event("acknowledged", 1, person="Ann", note="on my way"),
        event("updated", 2, epoch="e1", value=0.03, unit="m", note="30 mm", person=None),
        event("delivered", 3, note="no matter", person=None),
    )
    assert (alarm.epoch, alarm.raised_epoch, alarm.value, alarm.unit) == ("e1", "e0", 0.03, "m")
    assert (alarm.what, alarm.note, alarm.person) == ("30 mm", "on my way", "Ann")
    assert (alarm.raised_at, alarm.changed_at) == (epoch_time(0), epoch_time(0) + timedelta(minutes=2))
    assert alarm.eased_at is None


def test_an_eased_alarm_says_since_when(ws: Workspace) -> None:
    alarm = view_of(ws, event("raised", 0), event("eased", 9, value=0.001))
    assert (alarm.state, alarm.eased_at) == ("new", epoch_time(0) + timedelta(minutes=9))


def test_an_event_in_the_log_is_never_replaced(ws: Workspace) -> None:
    (row,) = append_alarm_events(ws, [event("raised", 0)])
    with pytest.raises(StorageError, match="in the log already, which is append only"):
        append_alarm_event(ws, replace(row, note="another"))


def test_one_process_delivers_at_a_time(ws: Workspace) -> None:
    refused: list[str] = []

    def try_it() -> None:
        try:
            with delivery_lock(ws, STRUCTURE, timeout_s=0.1):
                pass
        except StorageError as error:
            refused.append(str(error))

    with delivery_lock(ws, STRUCTURE):
        thread = threading.Thread(target=try_it)
        thread.start()
        thread.join(timeout=60.0)
    assert "the delivery of alarms of chimney-01" in refused[0]


def test_events_keep_their_order_and_their_times_when_the_clock_is_set_back(ws: Workspace) -> None:
    raised = event("raised", 540)
    seen = event("acknowledged", 120)
    first, second = append_alarm_events(ws, [raised])[0], append_alarm_events(ws, [seen])[0]
    assert second.event > first.event
    assert (first.happened_at, second.happened_at) == (raised.happened_at, seen.happened_at)
    rebuild_catalog(ws)
    (alarm,) = views.alarm_rows(ws, STRUCTURE)
    assert (alarm.state, alarm.raised_at) == ("acknowledged", raised.happened_at)
    assert [row.action for row in views.alarm_event_rows(ws, STRUCTURE)] == ["raised", "acknowledged"]
    assert alarms_of([second, first])[0].events == (first, second)
