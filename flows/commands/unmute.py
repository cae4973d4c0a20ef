"""``tiltwatch unmute``: let a muted alarm speak again."""

from flows.alarm_command import AlarmName, OptionalRemark, Person, Words, act
from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder


def unmute(
    file: CampaignFile,
    alarm: AlarmName,
    /,
    *,
    name: Person,
    note: OptionalRemark = None,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Let a muted alarm speak again.

    It counts in status, and what happened meanwhile is sent.
    """
    return act(file, alarm, Words("unmuted", name, note), workspace=workspace, as_json=as_json)
