"""The alarms as they stood at an epoch: from their events, without what later epochs brought."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

from storage.records import AlarmEventRow


@dataclass(frozen=True, slots=True)
class AlarmThen:
    """An alarm at an epoch: what its rule found last by then, and what became of it."""

    rule: str
    severity: str
    raised_epoch: str | None
    what: str
    state: str
    person: str | None


FOUND: Final = ("raised", "updated", "eased")
STATES: Final = {"acknowledged": "acknowledged", "muted": "muted", "unmuted": "new", "closed": "closed"}


def alarms_at(events: Sequence[AlarmEventRow], epochs: Collection[str]) -> tuple[AlarmThen, ...]:
    """Follow the events that belong to the given epochs, the earliest alarm first."""
    alarms: dict[str, AlarmThen] = {}
    for event in sorted(events, key=lambda each: each.event):
        if event.epoch not in epochs:
            continue
        known = alarms.get(event.alarm)
        if event.action == "raised":
            alarms[event.alarm] = AlarmThen(
                event.rule, event.severity, event.epoch, _what(event), "new", None
            )
        elif known is not None and event.action in FOUND:
            alarms[event.alarm] = replace(known, severity=event.severity, what=_what(event))
        elif known is not None and event.action in STATES:
            person = event.person or known.person
            alarms[event.alarm] = replace(known, state=STATES[event.action], person=person)
    return tuple(alarms.values())


def _what(event: AlarmEventRow) -> str:
    return event.note or f"{event.value:.4g} > {event.limit_value:.4g} {event.unit or ''}".strip()
