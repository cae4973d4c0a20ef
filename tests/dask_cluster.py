"""A real Dask cluster on loopback: a scheduler and workers as processes of their own, stopped by their ids."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from distributed import Client

ROOT = Path(__file__).resolve().parents[1]
START_S = 120.0
STOP_S = 15.0

# workers of one core each; nothing below a stage may take another
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"), "1"
)
# Dask looks at itself fifty times a second, and into the stack of every stage a hundred times
FEWER_LOOKS = {
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "2s",
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "false",
}


@dataclass(frozen=True)
class DaskCluster:
    """Where the scheduler listens."""

    address: str

    def worker_processes(self) -> dict[str, int]:
        """Process ids of the workers, by their addresses; a killed one is replaced by its keeper."""
        with self._client() as client:
            return client.run(os.getpid)

    def busy_workers(self) -> dict[str, tuple[str, ...]]:
        """Which calls the workers are at, by their addresses."""
        with self._client() as client:
            return {address: tuple(keys) for address, keys in client.processing().items() if keys}

    @contextmanager
    def _client(self) -> Iterator[Client]:
        client = Client(self.address, set_as_default=False, timeout=START_S)
        try:
            yield client
        finally:
            client.close()


@contextmanager
def dask_cluster(folder: Path, workers: int, environment: Mapping[str, str]) -> Iterator[DaskCluster]:
    """Run a cluster as long as the block lasts; the workers see the environment and this checkout."""
    folder.mkdir(parents=True, exist_ok=True)
    place = folder / "scheduler.json"
    settings = {**os.environ, **ONE_THREAD, **FEWER_LOOKS, **environment, "PYTHONPATH": str(ROOT)}
    scheduler = [*("scheduler", "--host", "127.0.0.1", "--port", "0"), "--scheduler-file", str(place)]
    worker = ["worker", "--scheduler-file", str(place), "--nthreads", "1", "--host", "127.0.0.1"]
    commands = {"scheduler": scheduler}
    for number in range(workers):
        commands[f"worker-{number}"] = [*worker, "--local-directory", str(folder / f"worker-{number}")]
    started: list[subprocess.Popen[bytes]] = []
    try:
        for name, words in commands.items():
            with (folder / f"{name}.log").open("wb") as log:
                command = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
                started.append(
                    subprocess.Popen(command, env=settings, cwd=folder, stdout=log, stderr=subprocess.STDOUT)
                )
        address = _address(place, started)
        with DaskCluster(address)._client() as client:
            client.wait_for_workers(workers, timeout=START_S)
        yield DaskCluster(address)
    finally:
        _stop(started)


def _address(place: Path, started: list[subprocess.Popen[bytes]]) -> str:
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline:
        if any(process.poll() is not None for process in started):
            break
        with suppress(OSError, ValueError):
            return str(json.loads(place.read_bytes())["address"])
        time.sleep(0.1)
    logs = "\n".join(log.read_text()[-1000:] for log in place.parent.glob("*.log"))
    raise RuntimeError(f"the Dask scheduler did not start within {START_S} s:\n{logs}")


def _stop(started: list[subprocess.Popen[bytes]]) -> None:
    """End all at once; a worker whose keeper is gone ends itself."""
    for process in reversed(started):
        process.kill()
    for process in started:
        process.wait(STOP_S)
