"""``tiltwatch close``: end an alarm."""

from flows.alarm_command import AlarmName, Person, Remark, Words, act
from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder


def close(
    file: CampaignFile,
    alarm: AlarmName,
    /,
    *,
    name: Person,
    note: Remark,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """End an alarm; its rule raises a new one at the next epoch if need be.

    To keep a rule quiet over many epochs, mute its alarm instead.
    """
    return act(file, alarm, Words("closed", name, note), workspace=workspace, as_json=as_json)
