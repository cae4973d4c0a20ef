"""``tiltwatch reprocess``: all epochs again with a new method or version, and what it changed."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import (
    AsJson,
    CampaignFile,
    WorkspaceFolder,
    check_epochs,
    load_with_workspace,
    workspace_of,
)
from flows.commands.run import LOGS, Several
from flows.terminal import Json, answer, log_into, note, say
from storage.errors import InputError, UsageError

if TYPE_CHECKING:
    from storage.workspace import Workspace
    from tasks.settings import Campaign
    from tasks.version_report import VersionReport


def reprocess(
    file: CampaignFile,
    /,
    *,
    label: str | None = None,
    workspace: WorkspaceFolder = None,
    epoch: Several = (),
    force: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    as_json: AsJson = False,
) -> int:
    """Process epochs again with a new method or version, keep the old results, print what changed.

    The published results are kept under a name first and never deleted; then everything that the new code or the changed
    settings reach is computed anew. After an interruption the same name goes on. Exit codes are those of run.

    Parameters
    ----------
    label
        Name under which the present results are kept; "before-" and the time where none is given.
    epoch
        Only this epoch; may be given several times.
    force
        Compute also what is stored and would be the same.
    """
    from flows.progress import progress
    from flows.run_campaign import RunRequest, run_campaign
    from flows.run_report import answer_of, conditions_of_run, exit_code_of, tell_errors
    from storage.upgrade import ready_workspace
    from tasks.version_report import version_report, version_report_lines

    campaign = load_with_workspace(file, workspace)
    check_epochs(campaign, epoch)
    place = ready_workspace(workspace_of(campaign.folder, workspace))
    log_into(place.root / LOGS)
    epochs = epoch or tuple(each.id for each in campaign.epochs)
    version = _keep(place, campaign, epochs, label)
    with progress() as on_event:
        outcome = run_campaign(RunRequest(file, place.root, epoch, anew=force), on_event)
    found = conditions_of_run(campaign, outcome)
    report = version_report(place, campaign.structure.id, version, epochs, campaign.report.primary)
    tell_errors(outcome.epochs)
    code = exit_code_of(outcome.epochs, found, None)
    if as_json:
        return answer(code, {**answer_of(outcome, found), **_facts(report)})
    say(*version_report_lines(report))
    say("", f"run {outcome.run}: {outcome.computed} stages computed, {outcome.cached} cached")
    say(
        f"old results: views versions, version_tilt and version_changes; files in {_folder(place, campaign, version)}"
    )
    return code


def _keep(place: "Workspace", campaign: "Campaign", epochs: tuple[str, ...], label: str | None) -> str:
    """Put the published results aside; gives the name under which they are."""
    from flows.ledger import new_run_id
    from storage.archive import archive_version

    version = f"before-{new_run_id(place, campaign.structure.id)}" if label is None else _checked(label)
    kept = archive_version(place, campaign.structure.id, version, epochs, "processed again")
    note(
        f"{len(kept)} of {len(epochs)} epochs kept as version {version}; "
        f"after an interruption go on with --label {version}"
    )
    return version


def _checked(label: str) -> str:
    from storage.ids import check_id

    try:
        return check_id(label, "a version (--label)")
    except InputError as error:
        raise UsageError(str(error)) from error


def _folder(place: "Workspace", campaign: "Campaign", version: str) -> Path:
    return place.versions / campaign.structure.id / version


def _facts(report: "VersionReport") -> dict[str, Json]:
    changes = [{**asdict(row), "epoch_time": row.epoch_time.isoformat()} for row in report.changes]
    new = [{"epoch": row.epoch, "scheme": row.scheme, "method": row.method} for row in report.new]
    return {"version": report.version, "primary": list(report.primary), "changes": changes, "new": new}
