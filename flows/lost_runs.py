"""Flow runs of a deployment that nobody works on any more, and how they are begun again."""

from collections.abc import Iterable
from datetime import datetime, timedelta
from pathlib import Path
from typing import Final
from uuid import UUID

from prefect.client.orchestration import SyncPrefectClient
from prefect.client.schemas.filters import (
    DeploymentFilter,
    DeploymentFilterId,
    FlowRunFilter,
    FlowRunFilterState,
    FlowRunFilterStateType,
)
from prefect.client.schemas.objects import FlowRun, StateType
from prefect.exceptions import ObjectNotFound

from flows.flow_run_states import UNDER_WAY, crash
from flows.monitor_campaign import monitor_campaign
from flows.recovery import SettledRun
from storage.run_record import read_record, runs_on_record
from storage.workspace import Workspace

LOST_AFTER: Final = timedelta(minutes=10)
"""So long a run may take from when it is due to when it puts down its record: the start of a worker's process."""

AGAIN: Final = "again:"
"""Begins the tag of a run that was begun again; the number behind it says for which time."""


def crash_lost_runs(client: SyncPrefectClient, ws: Workspace, structure: str, now: datetime) -> list[FlowRun]:
    """Set runs of a structure's deployment that hold its slot, but left no record of a process, to Crashed.

    A worker that is killed between taking a run and starting its process leaves such a run.
    """
    try:
        found = client.read_deployment_by_name(f"{monitor_campaign.name}/{structure}")
    except ObjectNotFound:
        return []
    records = (read_record(ws, run) for run in runs_on_record(ws))
    on_record = {record.flow_run for record in records if record is not None}
    state = FlowRunFilterState(type=FlowRunFilterStateType(any_=UNDER_WAY))
    under_way = client.read_flow_runs(
        flow_run_filter=FlowRunFilter(state=state),
        deployment_filter=DeploymentFilter(id=DeploymentFilterId(any_=[found.id])),
    )
    lost = [
        run for run in under_way if str(run.id) not in on_record and _is_of(run, ws) and _is_late(run, now)
    ]
    crash(client, lost, "nobody works on this run: its worker was ended before it began")
    return lost


def begin_again(
    client: SyncPrefectClient, settled: Iterable[SettledRun], lost: Iterable[FlowRun], retries: int
) -> list[FlowRun]:
    """Ask for the runs of deployments that were cut short once more, each at most as often as ``retries`` says.

    Called twice for the same run it asks once. A run that somebody cancelled is not begun again.
    """
    ids = [UUID(run.record.flow_run) for run in settled if run.record.flow_run and run.record.deployment]
    return [
        again
        for run in [*(client.read_flow_run(found) for found in ids), *lost]
        if (again := _again(client, run, retries)) is not None
    ]


def _again(client: SyncPrefectClient, run: FlowRun, retries: int) -> FlowRun | None:
    before = next((int(tag[len(AGAIN) :]) for tag in run.tags if tag.startswith(AGAIN)), 0)
    if run.deployment_id is None or run.state_type == StateType.CANCELLED or before >= retries:
        return None
    return client.create_flow_run_from_deployment(
        run.deployment_id,
        parameters=run.parameters,
        tags=[*(tag for tag in run.tags if not tag.startswith(AGAIN)), f"{AGAIN}{before + 1}"],
        idempotency_key=f"again-{run.id}",
    )


def _is_of(run: FlowRun, ws: Workspace) -> bool:
    """Whether a run works on this workspace; parameters of a single run may name another."""
    named = run.parameters.get("workspace")
    return named is not None and Path(str(named)).expanduser().resolve() == ws.root


def _is_late(run: FlowRun, now: datetime) -> bool:
    due = run.state.timestamp if run.state is not None else run.expected_start_time
    return due is not None and now - due > LOST_AFTER
