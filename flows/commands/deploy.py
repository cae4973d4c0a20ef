"""``tiltwatch deploy``: put campaigns on the schedule of a workflow server."""
# ruff: noqa: PLC0415 (heavy imports stand inside the command)

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from flows.commands.options import AsJson, WorkspaceFolder, workspace_of
from flows.terminal import Json, answer, say
from storage.errors import UsageError

if TYPE_CHECKING:
    from flows.deployments import DeploymentPlan


def deploy(
    *files: Annotated[Path, Parameter(name="FILE", help="campaign files (TOML)")],
    pool: str = "tiltwatch",
    remove: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    workspace: WorkspaceFolder = None,
    as_json: AsJson = False,
) -> int:
    """Put campaigns on the schedule of a workflow server: one deployment a structure, named by its id.

    The server is the one that PREFECT_API_URL names. Schedule, time limit and retries stand in [schedule] of the
    campaign file; after an edit of the schedule call this again.

    Parameters
    ----------
    pool
        Work pool that runs them; made with type process if it is not there.
    remove
        Take the deployments off the server; workspaces and results stay.
    """
    from flows.deployments import deployment_plan, register
    from flows.deployments import remove as take_off
    from flows.server_access import server_client
    from tasks.settings import load_campaign

    _check(files, workspace)
    loaded = [(file, load_campaign(file)) for file in files]
    plans = [
        deployment_plan(campaign, file, workspace_of(campaign.folder, workspace)) for file, campaign in loaded
    ]
    _check_names(plans)
    with server_client() as client:
        if remove:
            told = [_removed(plan, was_there=take_off(client, plan.structure)) for plan in plans]
        else:
            told = [_deployed(plan, pool) for plan in plans if register(client, plan, pool)]
    if as_json:
        return answer(0, {"deployments": [_facts(plan) for plan in plans]})
    say(*told)
    return 0


def _check(files: tuple[Path, ...], workspace: Path | None) -> None:
    if not files:
        raise UsageError("deploy needs at least one campaign file")
    if workspace is not None and len(files) > 1:
        raise UsageError("--workspace fits one campaign file; leave it out for several")


def _check_names(plans: "list[DeploymentPlan]") -> None:
    names = [plan.structure for plan in plans]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(
                f"structure {name!r} is in more than one file; a deployment is named by its structure"
            )


def _removed(plan: "DeploymentPlan", *, was_there: bool) -> str:
    return f"{plan.full_name}: {'removed' if was_there else 'was not deployed'}"


def _deployed(plan: "DeploymentPlan", pool: str) -> str:
    return f"{plan.full_name}: {_when(plan)}, in pool {pool}"


def _when(plan: "DeploymentPlan") -> str:
    if plan.cron is None:
        return "only on request (no cron in [schedule])"
    return f"{plan.cron} {plan.timezone}{'' if plan.active else ', paused'}"


def _facts(plan: "DeploymentPlan") -> dict[str, Json]:
    return {
        "name": plan.full_name,
        "cron": plan.cron,
        "timezone": plan.timezone,
        "active": plan.active,
        **plan.parameters,
    }
