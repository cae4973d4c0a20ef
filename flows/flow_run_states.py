"""Ask the workflow server which runs it takes for running, and tell it of those that ended by force."""

import os
from collections.abc import Iterable, Sequence
from typing import Final
from uuid import UUID

from prefect.client.orchestration import SyncPrefectClient, get_client
from prefect.client.schemas.filters import (
    FlowRunFilter,
    FlowRunFilterId,
    FlowRunFilterState,
    FlowRunFilterStateType,
    FlowRunFilterTags,
    TaskRunFilter,
    TaskRunFilterState,
    TaskRunFilterStateType,
)
from prefect.client.schemas.objects import FlowRun, StateType
from prefect.settings import PREFECT_API_URL
from prefect.states import Crashed

from flows.prefect_home import OWN_ADDRESS, OWN_SERVER

UNDER_WAY: Final = [StateType.PENDING, StateType.RUNNING, StateType.CANCELLING, StateType.PAUSED]


def server_in_use() -> str:
    """Address of the server that runs of this process are told to; ``own`` where the workspace has one of its own."""
    address: str | None = PREFECT_API_URL.value()
    return OWN_SERVER if not address or address == os.environ.get(OWN_ADDRESS) else address


def tag_of(run: str) -> str:
    """Tag of the flow runs that belong to a run of tiltwatch."""
    return f"run:{run}"


def runs_under_way(client: SyncPrefectClient, run: str, flow_run: str | None = None) -> list[FlowRun]:
    """Flow runs that the server takes for being under way: those with the tag of a run, and the one of that id."""
    state = FlowRunFilterState(type=FlowRunFilterStateType(any_=UNDER_WAY))
    tagged = FlowRunFilter(state=state, tags=FlowRunFilterTags(all_=[tag_of(run)]))
    found = client.read_flow_runs(flow_run_filter=tagged)
    if flow_run is not None:
        same = FlowRunFilter(state=state, id=FlowRunFilterId(any_=[UUID(flow_run)]))
        found += client.read_flow_runs(flow_run_filter=same)
    return found


def crash(client: SyncPrefectClient, runs: Iterable[FlowRun], reason: str) -> None:
    """Set flow runs to Crashed, and those of their tasks that are taken for running; their slots are freed."""
    for run in runs:
        within = FlowRunFilter(id=FlowRunFilterId(any_=[run.id]))
        state = TaskRunFilterState(type=TaskRunFilterStateType(any_=UNDER_WAY))
        for task in client.read_task_runs(
            flow_run_filter=within, task_run_filter=TaskRunFilter(state=state), limit=200
        ):
            client.set_task_run_state(task.id, Crashed(message=reason), force=True)
        client.set_flow_run_state(run.id, Crashed(message=reason), force=True)


def crash_epochs_of(run: str, reason: str) -> None:
    """Set the flow runs of a run's epochs that the server still takes for running to Crashed."""
    with get_client(sync_client=True) as client:
        crash(client, runs_under_way(client, run), reason)


def ids_of(runs: Sequence[FlowRun]) -> set[str]:
    """Ids of flow runs as text."""
    return {str(run.id) for run in runs}
