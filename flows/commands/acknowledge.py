"""``tiltwatch acknowledge``: somebody has seen an alarm."""

from flows.alarm_command import AlarmName, Person, Remark, Words, act
from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder


def acknowledge(
    file: CampaignFile,
    alarm: AlarmName,
    /,
    *,
    name: Person,
    note: Remark,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Say that somebody has seen an alarm.

    It stays active, but is not sent any more until it becomes worse; when it eases it is closed.
    """
    return act(file, alarm, Words("acknowledged", name, note), workspace=workspace, as_json=as_json)
