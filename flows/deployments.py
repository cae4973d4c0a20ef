"""One deployment a structure: by the name of the module, with its schedule, and no second run beside the first.

Nothing is built, pushed or pulled: a worker runs in the environment where tiltwatch is installed, and reaches the
campaign file and the workspace under the paths of the deployment.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Final
from uuid import UUID

from prefect.client.orchestration import SyncPrefectClient
from prefect.client.schemas.actions import DeploymentScheduleCreate, WorkPoolCreate
from prefect.client.schemas.objects import ConcurrencyLimitStrategy, ConcurrencyOptions
from prefect.client.schemas.schedules import CronSchedule
from prefect.exceptions import ObjectNotFound
from prefect.utilities.callables import parameter_schema
from prefect.workers.process import ProcessWorker

from flows.monitor_campaign import monitor_campaign
from tasks.settings import Campaign

ENTRYPOINT: Final = "flows.monitor_campaign.monitor_campaign"
"""By module and with a dot: with a colon Prefect first takes it for the path of a file."""

POOL: Final = "tiltwatch"

SLUG: Final = "campaign-file"
"""Name of the schedule that the campaign file asks for; others that were added by hand have other names."""

JOB_VARIABLES: Final = {"env": {"OMP_NUM_THREADS": "1"}}
"""The stages run side by side; more threads below them only wait for each other."""


@dataclass(frozen=True, slots=True)
class DeploymentPlan:
    """What is to be deployed for one campaign."""

    structure: str
    parameters: dict[str, str]
    cron: str | None
    timezone: str
    active: bool

    @property
    def full_name(self) -> str:
        """Name under which a run of it can be asked for."""
        return f"{monitor_campaign.name}/{self.structure}"


def deployment_plan(campaign: Campaign, campaign_file: Path, workspace: Path) -> DeploymentPlan:
    """Say what is to be deployed for a campaign; paths become absolute, since a worker starts elsewhere."""
    parameters = {"campaign_file": str(campaign_file.absolute()), "workspace": str(workspace.absolute())}
    asked = campaign.schedule
    return DeploymentPlan(campaign.structure.id, parameters, asked.cron, asked.timezone, asked.active)


def register(client: SyncPrefectClient, plan: DeploymentPlan, pool: str = POOL) -> UUID:
    """Make the deployment of a campaign, or bring the one that is there up to date."""
    _ensure_pool(client, pool)
    return client.create_deployment(
        flow_id=client.create_flow_from_name(monitor_campaign.name),
        name=plan.structure,
        description="Process what is new in a campaign; what is stored and true to its digest is not computed again.",
        entrypoint=ENTRYPOINT,
        parameters=plan.parameters,
        parameter_openapi_schema=parameter_schema(monitor_campaign).model_dump_for_openapi(),
        enforce_parameter_schema=True,
        schedules=_schedules(plan),
        tags=["tiltwatch", f"structure:{plan.structure}"],
        # a second run would only wait for the first; CANCEL_NEW says so at once
        concurrency_limit=1,
        concurrency_options=ConcurrencyOptions(collision_strategy=ConcurrencyLimitStrategy.CANCEL_NEW),
        work_pool_name=pool,
        job_variables=JOB_VARIABLES,
        pull_steps=[],
    )


def remove(client: SyncPrefectClient, structure: str) -> bool:
    """Remove the deployment of a structure; False where there is none."""
    try:
        found = client.read_deployment_by_name(f"{monitor_campaign.name}/{structure}")
    except ObjectNotFound:
        return False
    client.delete_deployment(found.id)
    return True


def _schedules(plan: DeploymentPlan) -> list[DeploymentScheduleCreate]:
    if plan.cron is None:
        return []
    cron = CronSchedule(cron=plan.cron, timezone=plan.timezone)
    return [DeploymentScheduleCreate(schedule=cron, active=plan.active, slug=SLUG)]


def _ensure_pool(client: SyncPrefectClient, pool: str) -> None:
    """Make the work pool if it is not there; one that is there is left as it is, of whatever type."""
    try:
        client.read_work_pool(pool)
    except ObjectNotFound:
        template = ProcessWorker.get_default_base_job_template()
        client.create_work_pool(
            WorkPoolCreate(name=pool, type=ProcessWorker.type, base_job_template=template)
        )
