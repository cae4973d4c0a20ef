"""What the commands that act on one alarm have in common."""
# ruff: noqa: PLC0415 (heavy imports stand inside the function)

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Final

from cyclopts import Parameter

from flows.commands.options import load_with_workspace, workspace_of
from flows.terminal import answer, say
from storage.errors import UsageError

AlarmName = Annotated[
    str, Parameter(name="ALARM", help="id of the alarm, as `tiltwatch alarms FILE` shows it")
]
Person = Annotated[str, Parameter(name="--name", help="who does it; on record for good")]
Remark = Annotated[str, Parameter(name="--note", help="why; on record for good")]
OptionalRemark = Annotated[str | None, Parameter(name="--note", help="why; on record for good")]

LONGEST: Final = 2000


@dataclass(frozen=True, slots=True)
class Words:
    """What a person says on the command line about an alarm."""

    action: str
    """acknowledged, muted, unmuted or closed."""
    name: str
    note: str | None
    until: datetime | None = None


def act(file: Path, alarm: str, words: Words, *, workspace: Path | None, as_json: bool) -> int:
    """Do something to an alarm on behalf of a person, and say what it is now.

    Raises
    ------
    UsageError
        If there is no such alarm, the deed makes no sense for it, or name or note are empty.
    """
    from flows.alarm_text import facts_of_alarm, line_of_alarm
    from storage.upgrade import ready_workspace
    from storage.views import alarm_rows
    from tasks.alarm_deeds import Deed, act_on_alarm

    note = None if words.note is None else _said("--note", words.note)
    deed = Deed(action=words.action, person=_said("--name", words.name), note=note, until=words.until)
    campaign = load_with_workspace(file, workspace)
    place = ready_workspace(workspace_of(campaign.folder, workspace))
    structure = campaign.structure.id
    act_on_alarm(place, structure, alarm, deed, datetime.now(UTC))
    (row,) = [row for row in alarm_rows(place, structure) if row.alarm == alarm]
    if as_json:
        return answer(0, {"alarm": facts_of_alarm(row)})
    say(line_of_alarm(row))
    return 0


def _said(option: str, text: str) -> str:
    words = text.strip()
    if not words or len(words) > LONGEST or not words.isprintable():
        raise UsageError(f"{option} needs 1 to {LONGEST} printable characters in one line")
    return words
