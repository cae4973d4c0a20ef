"""Alarms with what happened to them, and what to type about them."""

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from storage.records import AlarmEventRow, AlarmRow
from storage.views.condition import is_active, sorted_alarms

STATES: Final = ("open", "muted", "closed", "all")
"""What the list can be narrowed to; open are those that nobody has closed or muted."""

_UNITS: Final = {"deg": "°", "d": " days", "h": " hours", "a": " years", "1": "", None: ""}


def quantity(value: float, unit: str | None) -> str:
    """A value of a rule as people write it: millimetres for metres."""
    if unit == "m":
        return f"{1e3 * value:.1f} mm"
    if unit == "m/a":
        return f"{1e3 * value:.2f} mm a year"
    return f"{value:.4g}{_UNITS.get(unit, f' {unit}')}"


def narrowed(alarms: Sequence[AlarmRow], state: str, rule: str | None) -> list[AlarmRow]:
    """The alarms of a state and a rule, the active ones first, in them the gravest."""
    kept = [row for row in alarms if rule is None or row.rule == rule]
    return [row for row in sorted_alarms(kept) if state in ("all", state_of(row))]


def state_of(alarm: AlarmRow) -> str:
    """Which of ``STATES`` an alarm belongs to."""
    return alarm.state if alarm.state in ("muted", "closed") else "open"


def in_words(alarm: AlarmRow) -> str:
    """The state of an alarm in words."""
    eased = "" if alarm.eased_at is None else ", eased"
    if alarm.state == "muted":
        return (
            "muted for good"
            if alarm.muted_until is None
            else f"muted until {alarm.muted_until:%Y-%m-%d %H:%M} UTC"
        )
    return f"{alarm.state}{eased}"


@dataclass(frozen=True, slots=True)
class Command:
    """A line to type, and what it does."""

    does: str
    line: str


def commands(alarm: AlarmRow, file: str | None) -> list[Command]:
    """What can be said about an alarm on the command line as it stands; capitals are to be filled in.

    Parameters
    ----------
    file : str or None
        Name of the campaign file; ``FILE`` stands where it is not at hand.
    """
    place = f"{shlex.quote(file or 'FILE')} {shlex.quote(alarm.alarm)} --name 'YOUR NAME'"
    found = {
        "acknowledge": Command(
            "Somebody has seen it: it stays active, but is not sent again until it becomes worse.",
            f"tiltwatch acknowledge {place} --note 'WHY'",
        ),
        "mute": Command(
            "Keep it quiet for a while: it does not count in status, and nothing is sent.",
            f"tiltwatch mute {place} --days 30 --note 'WHY'",
        ),
        "unmute": Command("Let it speak again.", f"tiltwatch unmute {place}"),
        "close": Command(
            "End it: its rule raises a new one at the next epoch if need be.",
            f"tiltwatch close {place} --note 'WHY'",
        ),
    }
    possible = {
        "new": ("acknowledge", "mute", "close"),
        "acknowledged": ("mute", "close"),
        "muted": ("unmute", "close"),
    }
    return [found[name] for name in possible.get(alarm.state, ())]


@dataclass(frozen=True, slots=True)
class Step:
    """What a rule found at an epoch, as a multiple of its limit."""

    epoch: str
    time: datetime
    value: float
    limit_value: float
    unit: str | None
    action: str

    @property
    def ratio(self) -> float | None:
        """Value over limit; None where the limit is zero."""
        return self.value / self.limit_value if self.limit_value else None


def courses(events: Iterable[AlarmEventRow], times: dict[str, datetime]) -> dict[str, list[Step]]:
    """How the value of each alarm went over its epochs, by alarm; those of no epoch are left out."""
    found: dict[str, dict[str, Step]] = {}
    for row in events:
        if row.epoch is None or row.epoch not in times or row.action not in ("raised", "updated", "eased"):
            continue
        step = Step(row.epoch, times[row.epoch], row.value, row.limit_value, row.unit, row.action)
        found.setdefault(row.alarm, {})[row.epoch] = step
    return {alarm: sorted(steps.values(), key=lambda step: step.time) for alarm, steps in found.items()}


def counts(alarms: Sequence[AlarmRow]) -> dict[str, int]:
    """How many alarms there are of each state, and of all."""
    by_state = {state: sum(state_of(row) == state for row in alarms) for state in STATES[:-1]}
    return {**by_state, "all": len(alarms)}


__all__ = [
    "STATES",
    "Command",
    "Step",
    "commands",
    "counts",
    "courses",
    "in_words",
    "is_active",
    "narrowed",
    "quantity",
    "state_of",
]
