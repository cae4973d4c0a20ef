"""``tiltwatch status``: the newest state."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from dataclasses import asdict
from datetime import UTC, datetime

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import answer, note, say
from storage.errors import StorageError


def status(file: CampaignFile, /, *, workspace: WorkspaceFolder = None, as_json: AsJson = False) -> int:
    """Print the newest state; the exit code tells quality, warning and alarm.

    The state: deviation with its uncertainty (k=2), limit and verdict, change since the reference, data, age.

    Exit code 6 (alarm): the deviation is above its limit for sure.
    Exit code 5 (warning): the limit lies within the uncertainty, or the change since the reference is significant.
    Exit code 4 (quality gate not passed): the epoch failed or is degraded, or the primary scheme gave no axis.
    Exit code 0: none of these. The highest wins.
    """
    from flows.condition_text import EXIT_CODES, facts_of, further_verdicts, lines_of
    from storage.upgrade import ready_workspace
    from storage.views import verdict_rows
    from storage.views.condition import conditions

    campaign = load_with_workspace(file, workspace)
    place = ready_workspace(workspace_of(campaign.folder, workspace))
    found = conditions(place, campaign.structure.id, campaign.report.primary)
    if not found:
        raise StorageError(
            f"{place.root} holds no epoch of {campaign.structure.id}; `tiltwatch run {file}` processes it"
        )
    newest, now = found[-1], datetime.now(UTC)
    code = EXIT_CODES[newest.level]
    further = further_verdicts(newest, verdict_rows(place, campaign.structure.id, newest.epoch.epoch))
    stored = {condition.epoch.epoch for condition in found}
    missing = [epoch.id for epoch in campaign.epochs if epoch.id not in stored]
    if as_json:
        beside = [asdict(row) for row in further]
        return answer(code, {**facts_of(newest, now), "not_processed": missing, "verdicts": beside})
    say(*lines_of(newest, now))
    say(*(f"beside it: {row.limit_name}: {row.verdict}; {row.reason}" for row in further))
    if missing:
        note(f"not processed yet: {', '.join(missing)}")
    return code
