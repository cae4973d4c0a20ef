"""Alarms as their events have made them."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from storage.records import AlarmEventRow
from tasks.alarms.model import SEVERITIES

FOUND: Final = ("raised", "updated", "eased")
"""What a rule found."""

SENT: Final = ("delivered", "delivery failed")
"""What became of messages."""


@dataclass(frozen=True, slots=True)
class Alarm:
    """An alarm with all that happened to it, the earliest first; messages are kept apart."""

    events: tuple[AlarmEventRow, ...]
    sent: tuple[AlarmEventRow, ...]

    @property
    def name(self) -> str:
        """Id of the alarm."""
        return self.events[0].alarm

    @property
    def rule(self) -> str:
        """Id of its rule."""
        return self.events[0].rule

    @property
    def raised(self) -> AlarmEventRow:
        """How it began; not the earliest event where a clock was set back."""
        return next(event for event in self.events if event.action == "raised")

    @property
    def found(self) -> AlarmEventRow:
        """What its rule found last."""
        return next(event for event in reversed(self.events) if event.action in FOUND)

    @property
    def closing(self) -> AlarmEventRow | None:
        """How it ended; None while it is open."""
        return next((event for event in self.events if event.action == "closed"), None)

    @property
    def is_open(self) -> bool:
        """Whether nobody has closed it."""
        return self.closing is None

    @property
    def is_eased(self) -> bool:
        """Whether the value was back within its limit when its rule was looked at last."""
        return self.found.action == "eased"

    @property
    def is_active(self) -> bool:
        """Whether it is open and its rule broken."""
        return self.is_open and not self.is_eased

    @property
    def is_acknowledged(self) -> bool:
        """Whether a person has seen it as grave as it is now."""
        grades = [SEVERITIES.index(e.severity) for e in self.events if e.action == "acknowledged"]
        return max(grades, default=-1) >= SEVERITIES.index(self.found.severity)

    @property
    def mute(self) -> AlarmEventRow | None:
        """How it was muted; None where it is not."""
        turns = [event for event in self.events if event.action in ("muted", "unmuted")]
        return turns[-1] if turns and turns[-1].action == "muted" else None

    def is_muted(self, now: datetime) -> bool:
        """Whether it is muted at a time."""
        return self.mute is not None and (self.mute.until is None or self.mute.until > now)


def alarms_of(events: Sequence[AlarmEventRow]) -> list[Alarm]:
    """Sort the events of a structure, the earliest first, into its alarms; what has no ``raised`` is none."""
    told: dict[str, list[AlarmEventRow]] = {}
    sent: dict[str, list[AlarmEventRow]] = {}
    for event in sorted(events, key=lambda event: event.event):
        into = sent if event.action in SENT else told
        into.setdefault(event.alarm, []).append(event)
    return [
        Alarm(tuple(happened), tuple(sent.get(name, ())))
        for name, happened in told.items()
        if any(event.action == "raised" for event in happened)
    ]
