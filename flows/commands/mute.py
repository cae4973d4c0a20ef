"""``tiltwatch mute``: keep an alarm quiet."""

from datetime import UTC, datetime, timedelta
from typing import Annotated

from cyclopts import Parameter

from flows.alarm_command import AlarmName, OptionalRemark, Person, Words, act
from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder
from storage.errors import UsageError


def mute(  # noqa: PLR0913 - the words of a command
    file: CampaignFile,
    alarm: AlarmName,
    /,
    *,
    name: Person,
    until: Annotated[str | None, Parameter(name="--until")] = None,
    days: float | None = None,
    note: OptionalRemark = None,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Keep an alarm quiet for a while, or for good.

    It does not count in status, and nothing is sent. When the time is over and the alarm still active, it is sent again.

    Parameters
    ----------
    until
        Until when, as 2026-12-31 (midnight UTC) or 2026-12-31T18:00:00+01:00; for good without --until and --days.
    days
        For so many days from now.
    """
    end = _end(until, days, datetime.now(UTC))
    return act(file, alarm, Words("muted", name, note, end), workspace=workspace, as_json=as_json)


def _end(until: str | None, days: float | None, now: datetime) -> datetime | None:
    if until is not None and days is not None:
        raise UsageError("--until and --days say the same thing; write one of them")
    try:
        end = None if until is None else datetime.fromisoformat(until)
        if days is not None:
            end = now + timedelta(days=days)
    except (ValueError, OverflowError) as fault:
        raise UsageError(
            f"--until needs a date or a time with its offset, --days a number; got {until or days!r}; "
            "write --until 2026-12-31T18:00:00+01:00 or --days 30"
        ) from fault
    if end is not None and end.tzinfo is None:
        if until is not None and len(until.strip()) > len("2026-12-31"):
            raise UsageError(f"--until {until} needs its offset from UTC; write --until {until}+00:00")
        end = end.replace(tzinfo=UTC)
    if end is not None and end <= now:
        raise UsageError(f"an alarm cannot be muted until {end:%Y-%m-%d %H:%M %Z}, which is over")
    return end
