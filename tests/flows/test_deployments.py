"""Deployments of campaigns, runs of them that nobody works on, and how they are begun again."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from prefect.client.orchestration import SyncPrefectClient, get_client
from prefect.client.schemas.objects import StateType
from prefect.states import Cancelled, Pending, Running

from flows.deployments import DeploymentPlan, deployment_plan, register, remove
from flows.flow_run_states import server_in_use
from flows.lost_runs import begin_again, crash_lost_runs
from flows.recovery import settle_dead_runs
from storage.run_record import held_record, record_of_this_process, runs_on_record
from storage.workspace import Workspace, open_workspace
from tasks.settings import load_campaign
from tests.flows.calls import call
from tests.unit.settings.campaign_text import WHOLE

STRUCTURE = "chimney-01"
NAME = f"monitor-campaign/{STRUCTURE}"


@pytest.fixture
def client(prefect_api: str) -> Iterator[SyncPrefectClient]:
    with get_client(sync_client=True) as found:
        yield found
        remove(found, STRUCTURE)


@pytest.fixture
def place(tmp_path: Path) -> Workspace:
    return open_workspace(tmp_path / "ws")


def plan_of(folder: Path, schedule: str = "") -> DeploymentPlan:
    file = folder / "campaign.toml"
    file.write_text(f"{WHOLE}\n[schedule]\n{schedule}\n", encoding="utf-8")
    return deployment_plan(load_campaign(file), file, folder / "ws")


def test_deploying_again_changes_the_one_deployment(client: SyncPrefectClient, tmp_path: Path) -> None:
    first = register(client, plan_of(tmp_path, 'cron = "30 6 * * *"'))
    paused = 'cron = "0 7 1 * *"\ntimezone = "Asia/Shanghai"\nactive = false'
    assert register(client, plan_of(tmp_path, paused)) == first
    found = client.read_deployment_by_name(NAME)
    (schedule,) = found.schedules
    assert schedule.schedule.model_dump()["cron"] == "0 7 1 * *"
    assert schedule.schedule.model_dump()["timezone"] == "Asia/Shanghai"
    assert not schedule.active
    assert found.parameters == {
        "campaign_file": str(tmp_path / "campaign.toml"),
        "workspace": str(tmp_path / "ws"),
    }
    assert found.global_concurrency_limit is not None
    assert found.global_concurrency_limit.limit == 1
    assert found.concurrency_options is not None
    assert found.concurrency_options.collision_strategy == "CANCEL_NEW"
    assert found.pull_steps == []


def test_without_a_cron_it_runs_on_request_only_and_a_cron_taken_out_is_gone(
    client: SyncPrefectClient, tmp_path: Path
) -> None:
    register(client, plan_of(tmp_path, 'cron = "30 6 * * *"'))
    register(client, plan_of(tmp_path))
    assert client.read_deployment_by_name(NAME).schedules == []


def test_the_command_deploys_and_removes(
    client: SyncPrefectClient, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan_of(tmp_path, 'cron = "30 6 * * *"\ntimezone = "Europe/Berlin"')
    file = tmp_path / "campaign.toml"
    assert call(capsys, "deploy", file).out == f"{NAME}: 30 6 * * * Europe/Berlin, in pool tiltwatch\n"
    assert client.read_deployment_by_name(NAME).parameters["workspace"] == str(tmp_path / "tiltwatch-data")
    assert call(capsys, "deploy", file, "--remove").out == f"{NAME}: removed\n"
    assert call(capsys, "deploy", file, "--remove").out == f"{NAME}: was not deployed\n"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([], "deploy needs at least one campaign file"),
        (["FILE", "FILE"], "structure 'chimney-01' is in more than one file"),
        (["FILE", "FILE", "--workspace", "ws"], "--workspace fits one campaign file"),
    ],
)
def test_what_cannot_be_deployed_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], told: str, prefect_api: str
) -> None:
    plan_of(tmp_path)
    named = [str(tmp_path / "campaign.toml") if word == "FILE" else word for word in words]
    answer = call(capsys, "deploy", *named)
    assert answer.code == 2
    assert told in answer.err


def test_a_run_taken_by_a_worker_that_was_killed_frees_its_slot_and_is_begun_again(
    client: SyncPrefectClient, place: Workspace
) -> None:
    deployment = register(client, plan_of(place.root.parent))
    lost, begun = (client.create_flow_run_from_deployment(deployment) for _ in range(2))
    client.set_flow_run_state(lost.id, Pending(), force=True)
    client.set_flow_run_state(begun.id, Running(), force=True)
    leave_record_of_dead_process(place, "run-1", str(begun.id), str(deployment))
    assert crash_lost_runs(client, place, STRUCTURE, datetime.now(UTC)) == []
    found = crash_lost_runs(client, place, STRUCTURE, datetime.now(UTC) + timedelta(hours=1))
    assert [run.id for run in found] == [lost.id]
    assert client.read_flow_run(lost.id).state_type == StateType.CRASHED
    assert client.read_flow_run(begun.id).state_type == StateType.RUNNING
    (again,) = begin_again(client, [], found, retries=2)
    assert (again.parameters, again.deployment_id) == (lost.parameters, deployment)
    assert "again:1" in again.tags
    assert [run.id for run in begin_again(client, [], found, retries=2)] == [again.id]


def test_a_killed_run_is_begun_again_as_often_as_asked_and_a_cancelled_one_never(
    client: SyncPrefectClient, place: Workspace
) -> None:
    deployment = register(client, plan_of(place.root.parent))
    run = client.create_flow_run_from_deployment(deployment)
    for time in (1, 2):
        client.set_flow_run_state(run.id, Running(), force=True)
        leave_record_of_dead_process(place, f"run-{time}", str(run.id), str(deployment))
        settled = settle_dead_runs(place)
        assert [found.crashed for found in settled] == [(str(run.id),)]
        assert runs_on_record(place) == []
        (run,) = begin_again(client, settled, [], retries=2)
        assert f"again:{time}" in run.tags
    leave_record_of_dead_process(place, "run-3", str(run.id), str(deployment))
    assert begin_again(client, settle_dead_runs(place), [], retries=2) == []
    other = client.create_flow_run_from_deployment(deployment)
    client.set_flow_run_state(other.id, Cancelled(), force=True)
    leave_record_of_dead_process(place, "run-4", str(other.id), str(deployment))
    assert begin_again(client, settle_dead_runs(place), [], retries=2) == []


def test_a_record_of_another_server_waits_for_a_run_on_that_server(
    client: SyncPrefectClient, place: Workspace
) -> None:
    leave_record_of_dead_process(place, "run-1", None, None, server="http://elsewhere:4200/api")
    assert settle_dead_runs(place) == ()
    assert runs_on_record(place) == ["run-1"]


def leave_record_of_dead_process(
    place: Workspace, run: str, flow_run: str | None, deployment: str | None, server: str | None = None
) -> None:
    """A record as a killed process leaves it: its lock is free, and its process is none of today's."""
    record = record_of_this_process(run, STRUCTURE, server or server_in_use())
    record = replace(record, flow_run=flow_run, deployment=deployment, process_started_at=1.0)
    with held_record(place, record):
        pass
