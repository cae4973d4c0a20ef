"""``tiltwatch run``: process what is not processed yet."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter, validators

from flows.commands.options import (
    AsJson,
    CampaignFile,
    WorkspaceFolder,
    check_epochs,
    load_with_workspace,
    workspace_of,
)
from flows.terminal import answer, log_into, note, terminal
from flows.version import VERSION
from storage.errors import InputError, UsageError

if TYPE_CHECKING:
    from tasks.settings import Campaign

LOGS = "logs"

Several = Annotated[tuple[str, ...], Parameter(negative="", show_default=False)]
"""An option that may be given several times."""

TimeLimit = Annotated[float | None, Parameter(validator=validators.Number(gt=0.0))]
"""Seconds above zero."""


def run(  # noqa: PLR0913 - the words of a command
    file: CampaignFile,
    /,
    *,
    workspace: WorkspaceFolder = None,
    epoch: Several = (),
    scheme: Several = (),
    fail_on: Literal["quality", "warning", "alarm"] | None = None,
    time_limit_s: TimeLimit = None,
    only_new: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    as_json: AsJson = False,
) -> int:
    """Process what is not processed yet, and print Tables 1 to 3 of the paper for the newest epoch.

    With -v the tables of all epochs are printed. What is stored and true to its digest is not computed again.
    Exit code 3 if any epoch had bad input; the other epochs are processed all the same.

    Parameters
    ----------
    epoch
        Only this epoch; may be given several times.
    scheme
        Only this slicing scheme; may be given several times.
    fail_on
        From which state of any epoch of this run on the exit code tells it: 4 quality gate not passed, 5 warning,
        6 alarm.
    time_limit_s
        Longest time in seconds that an epoch may take. One that takes longer is ended, native code included, and the
        others go on; the epochs run in a process of their own then.
    only_new
        Look away from epochs whose scans, settings and code did not change since they were published: their scans are not
        even read. Without it every scan is read and compared with its digest.
    """
    # what is imported below takes a second
    note(f"tiltwatch {VERSION}: reading {file}")
    from flows.mending import code_with_losses, lost_after, mend_before

    lost = mend_before(workspace_of(file.absolute().parent, workspace))
    campaign = load_with_workspace(file, workspace)
    check_epochs(campaign, epoch)
    if scheme:
        _check_schemes(campaign, scheme)
    note(f"{campaign.structure.id}: {len(epoch or campaign.epochs)} epochs")
    from flows.progress import progress
    from flows.run_campaign import RunRequest, run_campaign
    from flows.run_report import answer_of, conditions_of_run, exit_code_of, tell_errors, tell_results

    place: Path = workspace_of(campaign.folder, workspace)
    log_into(place / LOGS)
    with progress() as on_event:
        outcome = run_campaign(
            RunRequest(file, place, epoch, scheme, time_limit_s, only_new=only_new), on_event, campaign
        )
    found = conditions_of_run(campaign, outcome)
    tell_errors(outcome.epochs)
    lost += lost_after(place)
    code = code_with_losses(exit_code_of(outcome.epochs, found, fail_on), lost)
    if as_json:
        return answer(code, {**answer_of(outcome, found), "lost": [asdict(told) for told in lost]})
    tell_results(campaign, outcome, found, all_epochs=terminal().verbose)
    return code


def _check_schemes(campaign: "Campaign", names: tuple[str, ...]) -> None:
    from tasks.plan import plan_axes

    try:
        plan_axes(campaign, names)
    except InputError as error:
        raise UsageError(str(error)) from error
