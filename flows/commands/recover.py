"""``tiltwatch recover``: settle runs that were killed, and begin them again."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, CampaignFile, WorkspaceFolder, load_with_workspace, workspace_of
from flows.terminal import answer, say
from storage.errors import UsageError

if TYPE_CHECKING:
    from storage.workspace import Workspace
    from tasks.settings import Campaign


def recover(
    file: CampaignFile,
    /,
    *,
    again: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Settle runs that were killed: what they did goes into the ledger, no server takes them for running any more.

    Every run does this for those before it. Where a dead run holds the only slot of a deployment none begins; then
    this frees it. Called by infra/systemd every hour; it may be called at any time.

    Parameters
    ----------
    again
        Ask the server of PREFECT_API_URL for the deployed runs among them once more, each at most as often as
        retries in [schedule] says.
    """
    from flows.prefect_home import prepare_prefect, users_server
    from storage.upgrade import ready_or_new_workspace, ready_workspace

    if again and users_server() is None:
        # the server of a workspace has no deployments
        raise UsageError(
            "needs the address of the workflow server of the deployments in PREFECT_API_URL, as "
            "http://127.0.0.1:4200/api (infra/README.md says how to start one)"
        )
    campaign = load_with_workspace(file, workspace)
    folder = workspace_of(campaign.folder, workspace)
    # a run of a deployment may be lost before it has made its workspace
    place = ready_or_new_workspace(folder) if again else ready_workspace(folder)
    prepare_prefect(place, campaign.execution.keep_server_s).wait()
    settled, lost, begun = _with_server(campaign, place) if again else (_without_server(place), [], [])
    if as_json:
        return answer(0, {"settled": settled, "lost": lost, "again": begun})
    say(*(f"run {run} did not finish, and is settled" for run in settled))
    say(*(f"flow run {run} was nobody's, and is crashed" for run in lost))
    say(*(f"flow run {run} does it again" for run in begun))
    if not settled and not lost:
        say("every run has finished or is under way")
    return 0


def _without_server(place: "Workspace") -> list[str]:
    from flows.recovery import settle_dead_runs

    return [run.record.run for run in settle_dead_runs(place)]


def _with_server(campaign: "Campaign", place: "Workspace") -> tuple[list[str], list[str], list[str]]:
    from flows.lost_runs import begin_again, crash_lost_runs
    from flows.recovery import settle_dead_runs
    from flows.server_access import server_client

    with server_client() as client:
        settled = settle_dead_runs(place)
        lost = crash_lost_runs(client, place, campaign.structure.id, datetime.now(UTC))
        begun = begin_again(client, settled, lost, campaign.schedule.retries)
    return (
        [run.record.run for run in settled],
        [run.name for run in lost],
        [run.name for run in begun],
    )
