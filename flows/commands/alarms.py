"""``tiltwatch alarms``: what is wrong, and who has seen it."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import answer, complain, note, say
from storage.errors import UsageError

if TYPE_CHECKING:
    from tasks.settings import Campaign

NOT_TAKEN = 3

Switch = Annotated[bool, Parameter(negative="", show_default=False)]


def alarms(
    file: CampaignFile,
    /,
    *,
    show_all: Annotated[bool, Parameter(name="--all", negative="", show_default=False)] = False,
    evaluate: Switch = False,
    trial: Switch = False,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """List the alarms, the active ones first; --evaluate looks for new ones and delivers them.

    Exit code 6: an alarm of severity alarm is active. Exit code 5: one of severity warning is. Those that are muted,
    have eased or are closed do not count. --evaluate belongs into cron, say every hour: it finds campaigns that were
    missed, and sends again what could not be delivered.

    Parameters
    ----------
    show_all
        Closed alarms, too.
    evaluate
        Hold the record against the rules now, and send what is due.
    trial
        Send a trial message to every [[notify]] and do nothing else. Exit code 3 if one was not taken.
    """
    from flows.alarm_text import facts_of_alarm, line_of_alarm
    from flows.condition_text import EXIT_CODES
    from storage.upgrade import ready_workspace
    from storage.views import alarm_rows
    from storage.views.condition import level_of, sorted_alarms

    campaign = load_with_workspace(file, workspace)
    if trial:
        return _trial(campaign, as_json=as_json)
    place = ready_workspace(workspace_of(campaign.folder, workspace))
    if evaluate:
        from flows.alarm_delivery import evaluate_and_deliver

        alarmed = evaluate_and_deliver(place, campaign, datetime.now(UTC))
        note(f"{len(alarmed.events)} events added to the log of alarms, {len(alarmed.sent)} messages tried")
        complain(*(f"warning: not delivered: {failure}" for failure in alarmed.failures))
    rows = sorted_alarms(alarm_rows(place, campaign.structure.id))
    code = EXIT_CODES[level_of(rows)]
    shown = [row for row in rows if show_all or row.state != "closed"]
    if as_json:
        return answer(
            code, {"structure": campaign.structure.id, "alarms": [facts_of_alarm(row) for row in shown]}
        )
    say(*(line_of_alarm(row) for row in shown))
    if not shown:
        say("no alarms" if show_all or not rows else f"no open alarms; {len(rows)} closed (--all)")
    return code


def _trial(campaign: "Campaign", *, as_json: bool) -> int:
    from flows.alarm_trial import send_trials

    if not campaign.notify:
        raise UsageError("the campaign file names no [[notify]]: there is nobody to send a trial message to")
    tried = dict(send_trials(campaign, datetime.now(UTC)))
    code = NOT_TAKEN if any(tried.values()) else 0
    if as_json:
        told = [
            {"target": target, "taken": reason is None, "reason": reason} for target, reason in tried.items()
        ]
        return answer(code, {"structure": campaign.structure.id, "trials": told})
    say(
        *(
            f"{target}: {'taken' if reason is None else f'not taken: {reason}'}"
            for target, reason in tried.items()
        )
    )
    return code
