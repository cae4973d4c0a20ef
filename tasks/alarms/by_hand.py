"""What a person may do to an alarm."""

from typing import Final

from tasks.alarms.history import Alarm

DEEDS: Final = ("acknowledged", "muted", "unmuted", "closed")
"""What the log says of them."""


def objection(alarm: Alarm, deed: str) -> str | None:
    """Why a deed makes no sense; None where it does."""
    if not alarm.is_open:
        return f"alarm {alarm.name!r} is closed already"
    if deed == "unmuted" and alarm.mute is None:
        return f"alarm {alarm.name!r} is not muted"
    return None
