"""Production in small: PostgreSQL, a server with a secret, a worker, and a deployment of a simulated campaign."""

import json
import os
import shutil
import subprocess
import sys
import time
import urllib.request
from base64 import b64encode
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from storage.parquet import read_rows
from storage.records import StageRunRow
from storage.tables import files_of
from storage.workspace import Workspace
from tests.flows.calls import ROOT, Called
from tests.flows.campaigns import STRUCTURE, small_campaign
from tests.infra.services import SECRET, Service, postgres, server_on

CALL_TIMEOUT_S = 180.0
NAME = f"monitor-campaign/{STRUCTURE}"
ENDED = {"COMPLETED", "FAILED", "CRASHED", "CANCELLED"}


@dataclass
class Production:
    """What stands, and how to use it as a user does."""

    folder: Path
    database: Service
    server: Service
    worker: Service
    api: str
    environment: dict[str, str]

    @property
    def campaign(self) -> Path:
        return self.folder / "campaign" / "campaign.toml"

    def call(self, *words: object, secret: str | None = SECRET) -> Called:
        """Call the command line in a process of its own."""
        environment = {**self.environment}
        environment.pop("PREFECT_API_AUTH_STRING")
        if secret is not None:
            environment["PREFECT_API_AUTH_STRING"] = secret
        done = subprocess.run(
            [sys.executable, "-P", "-m", "flows.cli", *(str(word) for word in words)],
            cwd=self.folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=CALL_TIMEOUT_S,
            check=False,
        )
        assert "Traceback" not in done.stderr, done.stderr
        return Called(done.returncode, done.stdout, done.stderr)

    def ask(self, path: str, content: dict[str, Any] | None = None) -> Any:
        """Ask the API of the server."""
        request = urllib.request.Request(  # noqa: S310 (a server of this test on loopback)
            f"{self.api}{path}",
            data=None if content is None else json.dumps(content).encode(),
            headers={
                "Content-Type": "application/json",
                "Authorization": f"Basic {b64encode(SECRET.encode()).decode()}",
            },
        )
        with urllib.request.urlopen(request, timeout=20) as answer:  # noqa: S310
            return json.load(answer)

    def deploy(self, workspace: Path) -> None:
        """Deploy the campaign on a workspace."""
        told = self.call("deploy", self.campaign, "--workspace", workspace)
        assert told.code == 0, told.err

    def deployment(self) -> dict[str, Any]:
        """The deployment as the server has it."""
        return self.ask(f"/deployments/name/{NAME}")

    def begin(self, **parameters: object) -> dict[str, Any]:
        """Ask for a run of the deployment."""
        return self.ask(
            f"/deployments/{self.deployment()['id']}/create_flow_run",
            {"parameters": parameters, "state": {"type": "SCHEDULED"}},
        )

    def runs_of(self, workspace: Path) -> list[dict[str, Any]]:
        """All flow runs that the server knows of a workspace, those of its epochs too."""
        found = self.ask("/flow_runs/filter", {"limit": 200})
        return [run for run in found if run["parameters"].get("workspace") == str(workspace)]

    def states_of(self, workspace: Path) -> dict[str, str]:
        """State of every flow run of a workspace by its name."""
        return {run["name"]: run["state_type"] for run in self.runs_of(workspace)}


def wait_until(what: str, holds: Callable[[], bool], limit_s: float = 240.0) -> None:
    """Wait until something holds, with a time limit."""
    deadline = time.monotonic() + limit_s
    while not holds():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {limit_s:g} s until {what}")
        time.sleep(0.3)


def asked_stages(workspace: Path) -> list[str]:
    """Stages that the runs under way have asked for so far, as their journals tell."""
    lines = [
        json.loads(line)
        for path in (workspace / "runs" / "active").glob("*.jsonl")
        for line in path.read_bytes().splitlines()
        if line.strip()
    ]
    return [f"{line['asked']['epoch']} {line['asked']['stage']}" for line in lines if "asked" in line]


def ledger(workspace: Path) -> list[StageRunRow]:
    """Every row of the ledger."""
    return [
        row for path in files_of(Workspace(workspace), "runs") for row in read_rows(path, "runs", StageRunRow)
    ]


@contextmanager
def production(folder: Path, epochs: int) -> Iterator[Production]:
    """Set it up, and stop all of it at the end."""
    small_campaign(folder / "campaign", epochs=epochs, stations=5)
    # code of its own: an edit of the working tree meanwhile would rightly compute everything again
    for package in ("flows", "tasks", "storage"):
        shutil.copytree(
            ROOT / package, folder / "code" / package, ignore=shutil.ignore_patterns("__pycache__")
        )
    with ExitStack() as stack:
        database, url = stack.enter_context(postgres(folder))
        server, api = stack.enter_context(server_on(url, folder / "server"))
        environment = {
            **{name: value for name, value in os.environ.items() if not name.startswith("PREFECT_")},
            "PREFECT_API_URL": api,
            "PREFECT_API_AUTH_STRING": SECRET,
            "PREFECT_HOME": str(folder / "client"),
            "PREFECT_LOGGING_LEVEL": "INFO",
            "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
            "PREFECT_WORKER_QUERY_SECONDS": "2",
            "PYTHONPATH": str(folder / "code"),
            "DO_NOT_TRACK": "1",
        }
        command = [
            sys.executable,
            "-P",
            "-m",
            "prefect",
            "worker",
            "start",
            "--pool",
            "tiltwatch",
            "--type",
            "process",
        ]
        worker = Service(
            "the worker", command, folder / "worker.log", lambda: True, environment, folder=folder
        )
        stack.callback(worker.stop)
        yield Production(folder, database, server, worker, api, environment)
