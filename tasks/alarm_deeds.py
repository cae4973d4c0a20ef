"""What people do to alarms: acknowledge, mute, unmute, close; each with a name, and on record for good."""

from dataclasses import dataclass, replace
from datetime import datetime

from storage.alarm_log import UNNUMBERED, append_alarm_events
from storage.catalog import rebuild_catalog
from storage.errors import UsageError
from storage.locks import publish_lock
from storage.records import AlarmEventRow
from storage.views import alarm_event_rows, epoch_rows
from storage.workspace import Workspace
from tasks.alarm_evaluation import event_of
from tasks.alarms import Alarm, alarms_of, objection, settle


@dataclass(frozen=True, slots=True, kw_only=True)
class Deed:
    """What a person does to an alarm."""

    action: str
    """acknowledged, muted, unmuted or closed."""
    person: str
    note: str | None = None
    until: datetime | None = None
    """Until when it is muted; None for good."""


def act_on_alarm(
    workspace: Workspace, structure: str, name: str, deed: Deed, now: datetime
) -> list[AlarmEventRow]:
    """Add a deed to the log; an eased alarm that is acknowledged is closed with it.

    Returns
    -------
    list of AlarmEventRow
        What was added.

    Raises
    ------
    UsageError
        If there is no such alarm, or the deed makes no sense for it.
    StorageError
        If the catalog or the log cannot be read or written.
    """
    with publish_lock(workspace):
        rebuild_catalog(workspace)
        known = alarm_event_rows(workspace, structure)
        alarm = _alarm(alarms_of(known), name, structure)
        if reason := objection(alarm, deed.action):
            raise UsageError(f"{reason}; `tiltwatch alarms FILE --all` shows what happened to it")
        added = append_alarm_events(workspace, [_row(workspace, alarm, deed, now)])
        changed = next(one for one in alarms_of([*known, *added]) if one.name == name)
        if step := settle(changed):
            added += append_alarm_events(workspace, [event_of(structure, step, now)])
        rebuild_catalog(workspace)
    return added


def _alarm(alarms: list[Alarm], name: str, structure: str) -> Alarm:
    for alarm in alarms:
        if alarm.name == name:
            return alarm
    known = ", ".join(alarm.name for alarm in alarms if alarm.is_open) or "none"
    raise UsageError(f"{structure} has no alarm {name!r}; open: {known}")


def _row(workspace: Workspace, alarm: Alarm, deed: Deed, now: datetime) -> AlarmEventRow:
    """The deed as an event; a closing carries the newest epoch, so that only a later one can raise the rule anew."""
    epoch = alarm.found.epoch
    if deed.action == "closed":
        stored = epoch_rows(workspace, alarm.found.structure)
        epoch = stored[-1].epoch if stored else epoch
    return replace(
        alarm.found,
        event=UNNUMBERED,
        epoch=epoch,
        action=deed.action,
        happened_at=now,
        person=deed.person,
        note=deed.note,
        until=deed.until,
    )
