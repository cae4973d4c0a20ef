"""infra/prefect.yaml: deployed to a server, its run is taken by a worker and publishes an epoch."""

import json
import os
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from storage.workspace import Workspace
from tests.flows.campaigns import STRUCTURE, rows, small_campaign

ROOT = Path(__file__).resolve().parents[2]
EPOCH = "2025-01"
NAME = "monitor-campaign/periodic"
CALL_TIMEOUT_S = 120.0


@dataclass(frozen=True)
class Site:
    """A server, a campaign of one epoch, and a folder of no checkout to call from."""

    api: str
    folder: Path

    @property
    def campaign(self) -> Path:
        return self.folder / "campaign" / "campaign.toml"

    @property
    def workspace(self) -> Path:
        return self.folder / "ws"

    def prefect(self, *words: object, cwd: Path | None = None) -> str:
        """Call the prefect command as the README says; ends by itself or by the time limit."""
        environment = {
            **os.environ,
            "PREFECT_API_URL": self.api,
            "PREFECT_LOGGING_LEVEL": "INFO",
            "PREFECT_LOGGING_TO_API_ENABLED": "true",
            "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
            "PYTHONPATH": str(ROOT),
            "TILTWATCH_CAMPAIGN": str(self.campaign),
            "TILTWATCH_WORKSPACE": str(self.workspace),
        }
        done = subprocess.run(
            [sys.executable, "-m", "prefect", "--no-prompt", *(str(word) for word in words)],
            cwd=cwd or self.folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=CALL_TIMEOUT_S,
            check=False,
        )
        assert done.returncode == 0, f"prefect {words}:\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
        return done.stdout

    def ask(self, path: str, content: dict[str, Any] | None = None) -> Any:
        """Ask the API of the server."""
        request = urllib.request.Request(  # noqa: S310 (the fixture's server on loopback)
            f"{self.api}{path}",
            data=None if content is None else json.dumps(content).encode(),
            headers={"Content-Type": "application/json"},
        )
        with urllib.request.urlopen(request, timeout=20) as answer:  # noqa: S310
            return json.load(answer)

    def run(self, **parameters: object) -> dict[str, Any]:
        """Ask for a run of the deployment and let a worker take it; gives the run as the server has it."""
        (run,) = self.runs(1, **parameters)
        return run

    def runs(self, count: int, **parameters: object) -> list[dict[str, Any]]:
        """Ask for several runs at once, and let one worker take them."""
        deployment = self.ask(f"/deployments/name/{NAME}")["id"]
        asked = [
            self.ask(f"/deployments/{deployment}/create_flow_run", {"parameters": parameters})
            for _ in range(count)
        ]
        self.prefect("worker", "start", "--pool", "tiltwatch", "--run-once")
        return [self.ask(f"/flow_runs/{run['id']}") for run in asked]

    def log_of(self, run: dict[str, Any]) -> str:
        """What a run and the runs of its epochs logged."""
        within = {"flow_runs": {"parent_flow_run_id": {"any_": [run["id"]]}}}
        ids = [run["id"], *(epoch["id"] for epoch in self.ask("/flow_runs/filter", within))]
        lines = self.ask("/logs/filter", {"logs": {"flow_run_id": {"any_": ids}}, "limit": 200})
        return "\n".join(line["message"] for line in lines)


@pytest.fixture(scope="module")
def site(prefect_api: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """The deployment of infra/prefect.yaml on a campaign of one small epoch."""
    found = Site(prefect_api, tmp_path_factory.mktemp("site"))
    small_campaign(found.folder / "campaign")
    found.prefect("work-pool", "create", "--type", "process", "tiltwatch", "--overwrite")
    found.prefect("deploy", "--prefect-file", ROOT / "infra" / "prefect.yaml", "--all", cwd=ROOT)
    yield found
    found.prefect("deployment", "delete", NAME)
    found.prefect("work-pool", "delete", "tiltwatch")


@pytest.mark.slow
def test_deployment_is_by_module_and_holds_no_folder_of_whoever_deployed(site: Site) -> None:
    deployment = site.ask(f"/deployments/name/{NAME}")
    assert deployment["entrypoint"] == "flows.monitor_campaign.monitor_campaign"
    assert not deployment["pull_steps"]
    assert str(ROOT) not in json.dumps(deployment)


@pytest.mark.slow
def test_deployment_has_a_schedule_with_a_time_zone_and_one_run_at_a_time(site: Site) -> None:
    deployment = site.ask(f"/deployments/name/{NAME}")
    (schedule,) = deployment["schedules"]
    assert schedule["schedule"]["timezone"] == "Europe/Berlin"
    assert schedule["schedule"]["cron"] == "30 6 * * *"
    assert deployment["global_concurrency_limit"]["limit"] == 1
    assert deployment["concurrency_options"]["collision_strategy"] == "CANCEL_NEW"


@pytest.mark.slow
def test_worker_takes_a_run_and_the_epoch_is_published(site: Site) -> None:
    run = site.run(schemes=["A", "B"])
    assert run["state_type"] == "COMPLETED", site.log_of(run)
    assert {row.scheme for row in rows(site.workspace, "tilt", EPOCH)} == {"A", "B"}
    place = Workspace(site.workspace)
    assert place.catalog.is_file()
    assert len(list((place.tables / "runs" / STRUCTURE).glob("*.parquet"))) == 1
    # the records of the stages are what a later run finds
    assert list(place.records.glob("evaluation-*"))
    assert f"{EPOCH} registration: computed" in site.log_of(run)


@pytest.mark.slow
def test_run_in_which_an_epoch_failed_is_failed(site: Site) -> None:
    other = small_campaign(site.folder / "other")
    for scan in other.parent.glob("*/*.laz"):
        scan.unlink()
    run = site.run(campaign_file=str(other), workspace=str(site.folder / "other-ws"))
    assert run["state_type"] == "FAILED", site.log_of(run)
    assert "1 of 1 epochs failed" in run["state"]["message"]
    assert "no such file" in run["state"]["message"]


@pytest.mark.slow
def test_second_run_at_the_same_time_is_cancelled(site: Site) -> None:
    runs = site.runs(2, schemes=["A", "B"])
    assert sorted(run["state_type"] for run in runs) == ["CANCELLED", "COMPLETED"]
