"""The server of a run that was killed does not outlive the next run."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from filelock import FileLock

from flows.ephemeral_server import MARK, SERVER, stop_orphans
from tests.flows.calls import ROOT
from tests.flows.campaigns import small_campaign

WAIT_S = 60.0


@pytest.fixture
def lock(tmp_path: Path) -> FileLock:
    """The lock of a run on the home ``tmp_path``."""
    (tmp_path / "servers").mkdir()
    (tmp_path / "servers" / "abc.lock").touch()
    return FileLock(tmp_path / "servers" / "abc.lock")


@pytest.fixture
def server(request: pytest.FixtureRequest) -> Iterator[subprocess.Popen[bytes]]:
    """A process with the mark and the words of a server; other ones where the test says so."""
    mark, word = getattr(request, "param", ("abc", SERVER))
    command = [sys.executable, "-c", "import time; time.sleep(60)", word]
    process = subprocess.Popen(command, env={**os.environ, MARK: mark})
    # between fork and exec the process still shows the words of this one
    _wait_for(lambda: word in psutil.Process(process.pid).cmdline())
    yield process
    process.kill()
    process.wait()


def _wait_for(condition) -> None:  # type: ignore[no-untyped-def]
    deadline = time.monotonic() + WAIT_S
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.05)


def test_server_of_a_dead_run_is_stopped_once(
    tmp_path: Path, lock: FileLock, server: subprocess.Popen[bytes]
) -> None:
    assert stop_orphans(tmp_path) == (server.pid,)
    server.wait(5)
    assert not Path(lock.lock_file).exists()
    assert stop_orphans(tmp_path) == ()


def test_server_of_a_run_that_lives_is_left_alone(
    tmp_path: Path, lock: FileLock, server: subprocess.Popen[bytes]
) -> None:
    with lock:
        assert stop_orphans(tmp_path) == ()
    assert server.poll() is None


@pytest.mark.parametrize("server", [("other", SERVER), ("abc", "something else")], indirect=True)
@pytest.mark.usefixtures("lock")
def test_another_process_is_left_alone(tmp_path: Path, server: subprocess.Popen[bytes]) -> None:
    assert stop_orphans(tmp_path) == ()
    assert server.poll() is None


def test_home_without_servers_has_no_orphans(tmp_path: Path) -> None:
    assert stop_orphans(tmp_path / "not there") == ()


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="SIGKILL is POSIX's")
def test_server_of_a_killed_run_is_gone_after_the_next_run(tmp_path: Path) -> None:
    campaign = small_campaign(tmp_path / "campaign")
    command = [sys.executable, "-m", "flows.cli", "run", str(campaign), "--scheme", "A"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PREFECT_")}
    environment["PYTHONPATH"] = str(ROOT)
    killed = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    children: list[psutil.Process] = []

    def has_started() -> bool:
        children[:] = psutil.Process(killed.pid).children()
        return bool(children) and SERVER in children[0].cmdline()

    _wait_for(has_started)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    (orphan,) = children
    assert orphan.is_running()

    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)

    assert done.returncode == 0, done.stderr
    assert f"stopped process {orphan.pid}" in done.stderr
    _wait_for(lambda: not orphan.is_running() or orphan.status() == psutil.STATUS_ZOMBIE)
    assert not list((campaign.parent / "tiltwatch-data" / "prefect" / "servers").iterdir())
