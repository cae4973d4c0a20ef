"""What a message about an alarm says: to people as a text, to programs as an object."""

from collections.abc import Mapping
from datetime import datetime
from pathlib import Path

from flows.terminal import Json
from storage.records import AlarmEventRow, AlarmRow, EpochRow
from tasks.alarms import FOUND, RULES, Message
from tasks.settings import Campaign
from tasks.settings.alarms import Alarm as AlarmRule

NEWS: Mapping[str, str] = {
    "raised": "raised",
    "updated": "worse than before",
    "eased": "eased",
    "unmuted": "not muted any more, and still there",
    "closed": "closed: nothing is left of it",
}


def title_of(campaign: Campaign, event: AlarmEventRow) -> str:
    """One line: how grave, what, where."""
    epoch = f" (epoch {event.epoch})" if event.epoch else ""
    return f"{event.severity.upper()} {campaign.structure.id}: {event.rule} {NEWS[event.action]}{epoch}"


def body_of(campaign: Campaign, rule: AlarmRule, message: Message, epoch: EpochRow | None) -> str:
    """All that somebody needs who was woken by it: what was found, against which limit, what to do, and where."""
    event, found = message.event, message.alarm.found
    measured = "" if epoch is None else f", measured {epoch.epoch_time:%Y-%m-%d %H:%M %Z}"
    lines = [
        f"Structure: {campaign.structure.title} ({campaign.structure.id})",
        f"Epoch: {event.epoch}{measured}" if event.epoch else "Epoch: none",
        f"Rule: {event.rule} ({RULES[rule.when].description})",
        f"State: {event.severity}, {NEWS[event.action]}, {event.happened_at:%Y-%m-%d %H:%M %Z}",
        f"Note: {event.note}" if event.action not in FOUND and event.note else "",
        f"Found: {found.note}" if found.note else "",
        f"Value: {quantity_text(event.value, event.unit)}, limit {quantity_text(event.limit_value, event.unit)}",
    ]
    if event.action not in ("eased", "closed"):
        lines.append(f"What to do: {RULES[rule.when].advice}")
    lines.append(_where(campaign.folder, event))
    return "\n".join(line for line in lines if line)


def facts_of_event(campaign: Campaign, rule: AlarmRule, event: AlarmEventRow) -> dict[str, Json]:
    """The event for programs: metres, degrees, null where something does not exist."""
    return {
        "event": event.event,
        "alarm": event.alarm,
        "structure": event.structure,
        "structure_name": campaign.structure.title,
        "epoch": event.epoch,
        "rule": event.rule,
        "when": rule.when,
        "severity": event.severity,
        "action": event.action,
        "happened_at": event.happened_at.isoformat(),
        "value": event.value,
        "limit_value": event.limit_value,
        "unit": event.unit,
        "what": event.note,
    }


def facts_of_alarm(alarm: AlarmRow) -> dict[str, Json]:
    """An alarm for programs."""
    return {
        "alarm": alarm.alarm,
        "structure": alarm.structure,
        "epoch": alarm.epoch,
        "rule": alarm.rule,
        "severity": alarm.severity,
        "state": alarm.state,
        "value": alarm.value,
        "limit_value": alarm.limit_value,
        "unit": alarm.unit,
        "what": alarm.what,
        "raised_epoch": alarm.raised_epoch,
        "raised_at": alarm.raised_at.isoformat(),
        "changed_at": alarm.changed_at.isoformat(),
        "eased_at": _iso(alarm.eased_at),
        "muted_until": _iso(alarm.muted_until),
        "person": alarm.person,
        "note": alarm.note,
    }


def line_of_alarm(alarm: AlarmRow) -> str:
    """An alarm in one line, with what was said about it in a second one."""
    eased = f", eased {alarm.eased_at:%Y-%m-%d %H:%M %Z}" if alarm.eased_at else ""
    until = f" until {alarm.muted_until:%Y-%m-%d %H:%M %Z}" if alarm.muted_until else ""
    line = (
        f"{alarm.severity:<8}{alarm.state}{until}{eased}  {alarm.alarm}, raised"
        f" {alarm.raised_at:%Y-%m-%d %H:%M %Z}: {alarm.what}"
    )
    if alarm.note is None and alarm.person is None:
        return line
    by = f"by {alarm.person}" if alarm.person else "by the program"
    return f"{line}\n        {by}" + (f": {alarm.note}" if alarm.note else "")


def quantity_text(value: float, unit: str | None) -> str:
    """A value with its unit as people write it: millimetres for metres."""
    if unit == "m":
        return f"{1e3 * value:.1f} mm"
    if unit == "m/a":
        return f"{1e3 * value:.2f} mm a year"
    words = {"deg": "°", "d": " days", "h": " hours", "a": " years"}
    return f"{value:.4g}{words.get(unit or '', '')}"


def _where(folder: Path, event: AlarmEventRow) -> str:
    return (
        f"Acknowledge: tiltwatch acknowledge FILE {event.alarm} --name YOU --note WHY\n"
        f"  (FILE is the campaign file in {folder}; `tiltwatch alarms FILE` lists all)"
    )


def _iso(time: datetime | None) -> str | None:
    return None if time is None else time.isoformat()
