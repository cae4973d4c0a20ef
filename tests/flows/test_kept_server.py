"""A workspace has one workflow server: found again, shared, replaced where it died, and no one's orphan."""

import errno
import http.client
import json
import os
import socket
import sqlite3
import stat
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import asdict, replace
from pathlib import Path

import psutil
import pytest
from filelock import BaseFileLock

from flows import kept_server, server_check
from flows.kept_server import Lease, NoServerError, ServerSearch, keep_alive, lease_of
from flows.prefect_home import ADDRESS, OWN_ADDRESS, prepare_prefect, take_home, users_server
from flows.workflow_server import (
    FIRST_USE_S,
    LOOPBACK,
    ServerRecord,
    ServerRequest,
    Use,
    read_record,
    record_file,
    server_lock,
    version_of_servers,
)
from storage.errors import UsageError
from storage.workspace import Workspace
from tests.flows.calls import ROOT
from tests.flows.campaigns import small_campaign

WAIT_S = 90.0

KEEP_S = 2.0

HALF_WRITTEN = "server.0123456789abcdef"


def _wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + WAIT_S
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.05)


def _is_gone(pid: int) -> bool:
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def _answers(folder: Path) -> bool:
    record = read_record(folder)
    lease = None if record is None else lease_of(record)
    if lease is not None:
        lease.connection.close()
    return lease is not None


def _record(folder: Path, mark: str = "mark", port: int = 9) -> ServerRecord:
    return ServerRecord(mark, version_of_servers(), str(folder), os.getpid(), port, "user:secret")


@pytest.fixture(scope="module")
def lease(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lease]:
    """A server in a folder in which killed ones left a record, and one half written."""
    folder = tmp_path_factory.mktemp("home")
    with socket.socket() as free:
        free.bind((LOOPBACK, 0))
        stale = _record(folder, port=free.getsockname()[1])
    record_file(folder).write_text(json.dumps(asdict(stale)))
    (folder / HALF_WRITTEN).write_text("{")
    search = ServerSearch(folder, 0.0)
    assert not search.is_up
    held = search.wait()
    yield held
    held.connection.close()
    _wait_for(lambda: _is_gone(held.record.pid))
    assert not record_file(folder).exists()


def test_a_later_run_finds_the_server(lease: Lease) -> None:
    search = ServerSearch(Path(lease.record.folder), 0.0)
    assert search.is_up
    again = search.wait()
    again.connection.close()
    assert again.record == lease.record


def test_what_a_server_left_that_was_killed_while_it_wrote_its_record_is_swept_away(lease: Lease) -> None:
    folder = Path(lease.record.folder)
    assert not (folder / HALF_WRITTEN).exists()
    assert {path.name for path in folder.glob("server.*")} >= {"server.json"}


def test_a_server_whose_database_is_stuck_is_not_used(lease: Lease, monkeypatch: pytest.MonkeyPatch) -> None:
    """It answers what it is asked; a run would wait for minutes at every step, and then take it for its own fault."""
    folder = Path(lease.record.folder)
    monkeypatch.setattr(server_check, "WRITE_S", 1.0)
    with closing(sqlite3.connect(folder / "prefect.db", isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(NoServerError, match="its database took nothing in for 1 s; end process"):
            ServerSearch(folder, KEEP_S).wait()
        other.execute("ROLLBACK")
    assert _answers(folder)
    ServerSearch(folder, KEEP_S).wait().connection.close()


def test_nothing_listens_beyond_loopback(lease: Lease) -> None:
    found = psutil.Process(lease.record.pid).net_connections("inet")
    assert {made.laddr.ip for made in found if made.status == psutil.CONN_LISTEN} == {LOOPBACK}


@pytest.mark.skipif(os.name == "nt", reason="modes are POSIX's")
def test_only_the_owner_reads_the_secret(lease: Lease) -> None:
    assert stat.S_IMODE(record_file(Path(lease.record.folder)).stat().st_mode) == 0o600
    assert lease.record.secret not in " ".join(psutil.Process(lease.record.pid).cmdline())


def test_the_server_refuses_who_does_not_know_the_secret(lease: Lease) -> None:
    assert lease_of(replace(lease.record, secret="user:guess")) is None  # noqa: S106
    connection = http.client.HTTPConnection(LOOPBACK, lease.record.port)
    connection.request("GET", "/api/admin/version")
    assert connection.getresponse().status == 401
    connection.close()


@pytest.mark.slow
def test_two_at_once_start_one_server_which_goes_when_nobody_uses_it(tmp_path: Path) -> None:
    def one() -> Lease:
        return ServerSearch(tmp_path, KEEP_S).wait()

    with ThreadPoolExecutor(2) as pool:
        first, second = (asked.result() for asked in [pool.submit(one), pool.submit(one)])
    assert first.record == second.record
    first.connection.close()
    time.sleep(2.0 * KEEP_S)
    assert not _is_gone(first.record.pid)
    second.connection.close()
    _wait_for(lambda: _is_gone(first.record.pid))
    assert read_record(tmp_path) is None


@pytest.mark.slow
def test_a_server_that_is_killed_is_replaced_at_the_same_address_and_ends_with_its_folder(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "home"
    lease = ServerSearch(folder, 600.0).wait()
    keep_alive(lease, 600.0)
    psutil.Process(lease.record.pid).kill()

    _wait_for(lambda: read_record(folder) != lease.record and _answers(folder))
    record = read_record(folder)
    assert record is not None
    assert (record.url, record.secret) == (lease.record.url, lease.record.secret)
    folder.rename(tmp_path / "gone")
    _wait_for(lambda: _is_gone(record.pid))


@pytest.mark.slow
def test_a_server_that_cannot_start_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PREFECT_SERVER_DATABASE_CONNECTION_URL", "sqlite+aiosqlite:////not/there/x.db")
    with pytest.raises(NoServerError, match=r"it ended: .*server\.log"):
        ServerSearch(tmp_path, 0.0).wait()


@pytest.mark.slow
def test_runs_one_after_the_other_use_one_server_also_behind_one_that_was_killed(tmp_path: Path) -> None:
    campaign = small_campaign(tmp_path / "campaign")
    with campaign.open("a", encoding="utf-8") as file:
        file.write(f"\n[execution]\nkeep_server_s = {10.0 * KEEP_S}\n")
    command = [sys.executable, "-m", "flows.cli", "run", str(campaign), "--scheme", "A"]
    apart = ("PREFECT_", "TILTWATCH_KEEP_SERVER_S", OWN_ADDRESS)
    environment = {name: value for name, value in os.environ.items() if not name.startswith(apart)}
    environment["PYTHONPATH"] = str(ROOT)
    homes = campaign.parent / "tiltwatch-data" / "prefect"
    killed = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _wait_for(lambda: any(map(_answers, homes.glob("*"))))
    (home,) = [folder for folder in homes.iterdir() if record_file(folder).exists()]
    killed.kill()
    killed.wait()
    record = read_record(home)
    assert record is not None
    for _ in range(2):
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=120, check=False
        )
        assert done.returncode == 0, done.stderr
        assert read_record(home) == record
    assert "starting the workflow engine" not in done.stderr
    _wait_for(lambda: _is_gone(record.pid))


@pytest.fixture
def no_server() -> Iterator[None]:
    """An environment in which no server is named; afterwards it is as before, and Prefect has read it again."""
    before = dict(os.environ)
    for name in (ADDRESS, OWN_ADDRESS, "PREFECT_HOME", "PREFECT_API_AUTH_STRING"):
        os.environ.pop(name, None)
    yield
    os.environ.clear()
    os.environ.update(before)
    if "prefect" in sys.modules:
        from prefect.context import refresh_global_settings_context  # noqa: PLC0415 (slow to import)

        refresh_global_settings_context()


@pytest.mark.slow
def test_where_no_server_can_be_kept_a_run_has_one_that_ends_with_it_however_that_ends(
    tmp_path: Path,
) -> None:
    (tmp_path / "prefect").write_text("a file where the folder should be")
    apart = ("PREFECT_", OWN_ADDRESS)
    environment = {name: value for name, value in os.environ.items() if not name.startswith(apart)}
    run = [sys.executable, "-c", UNKEPT, str(tmp_path)]
    with subprocess.Popen(run, env=environment, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        server = int(process.stdout.readline())
        assert psutil.Process(server).ppid() == process.pid
        process.kill()
    _wait_for(lambda: _is_gone(server))


UNKEPT = """
import sys, time
from pathlib import Path
from flows.prefect_home import _followed, prepare_prefect
from flows.workflow_server import read_record
from storage.workspace import Workspace
prepare_prefect(Workspace(Path(sys.argv[1])), 600.0).wait()
(folder,) = _followed
print(read_record(Path(folder)).pid, flush=True)
time.sleep(100.0)
"""


@pytest.mark.usefixtures("no_server")
@pytest.mark.parametrize("text", ["soon", "-1", "nan", "inf"])
def test_a_time_to_keep_the_server_that_is_none_is_wrong_usage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    monkeypatch.setenv("TILTWATCH_KEEP_SERVER_S", text)
    with pytest.raises(UsageError, match=r"TILTWATCH_KEEP_SERVER_S is .*; give it seconds"):
        prepare_prefect(Workspace(tmp_path), 600.0)


@pytest.mark.skipif(os.name == "nt", reason="the sleeper is a shell script")
def test_a_server_that_tells_nothing_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept_server, "START_S", 0.5)
    monkeypatch.setattr("sys.executable", _sleeper(tmp_path))
    with pytest.raises(NoServerError, match="did not answer within"):
        ServerSearch(tmp_path / "home", 0.0)


def _sleeper(folder: Path) -> str:
    program = folder / "sleeper"
    program.write_text("#!/bin/sh\nexec sleep 100\n")
    program.chmod(0o700)
    return str(program)


@pytest.mark.usefixtures("no_server")
def test_machines_and_versions_on_one_workspace_have_a_home_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    homes = set()
    for host, program in (("a", "x"), ("b", "x"), ("a", "y"), ("a", "x")):
        monkeypatch.delenv("PREFECT_HOME", raising=False)
        monkeypatch.setattr("socket.gethostname", lambda host=host: host)
        monkeypatch.setattr("sys.executable", program)
        take_home(Workspace(tmp_path))
        homes.add(os.environ["PREFECT_HOME"])
    assert len(homes) == 3


@pytest.mark.usefixtures("no_server")
def test_a_server_that_the_user_names_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(ADDRESS, "http://127.0.0.1:9/api")
    prepare_prefect(Workspace(tmp_path), 600.0).wait()
    assert users_server() == "http://127.0.0.1:9/api"
    assert not (tmp_path / "prefect").exists()


@pytest.fixture
def use(tmp_path: Path) -> Use:
    """The server of ``tmp_path``, kept for 10 s, which nobody has used since 100 s."""
    record_file(tmp_path).write_text(json.dumps(asdict(_record(tmp_path))))
    return Use(ServerRequest(str(tmp_path), "mark", 10.0), unused_since_s=100.0)


def test_a_server_is_kept_so_long_after_its_last_use(use: Use) -> None:
    assert not use.is_over(connections=1, requests=1, now_s=200.0)
    assert not use.is_over(connections=0, requests=2, now_s=300.0)
    assert not use.is_over(connections=0, requests=2, now_s=309.0)
    assert use.is_over(connections=0, requests=2, now_s=310.0)
    assert read_record(Path(use.request.folder)) is None


def test_a_server_on_a_read_only_drive_ends_like_others(use: Use, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(_folder: Path) -> BaseFileLock:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr("flows.workflow_server.server_lock", refused)
    assert not use.is_over(connections=1, requests=1, now_s=200.0)
    assert use.is_over(connections=0, requests=1, now_s=212.0)


def test_a_server_waits_for_its_first_use(use: Use) -> None:
    assert not use.is_over(connections=0, requests=0, now_s=99.0 + FIRST_USE_S)
    assert use.is_over(connections=0, requests=0, now_s=100.0 + FIRST_USE_S)


def test_a_server_whose_place_another_has_ends_when_nobody_is_connected(use: Use) -> None:
    folder = Path(use.request.folder)
    record_file(folder).write_text(json.dumps(asdict(_record(folder, mark="another"))))
    assert not use.is_over(connections=1, requests=1, now_s=200.0)
    assert use.is_over(connections=0, requests=1, now_s=201.0)
    assert read_record(folder) is not None


def test_a_server_stays_while_somebody_is_about_to_use_it(use: Use) -> None:
    folder = Path(use.request.folder)
    with ThreadPoolExecutor(1) as pool:
        search = pool.submit(_taken, folder).result()
        assert not use.is_over(connections=0, requests=0, now_s=1000.0)
        pool.submit(search.release).result()
    assert use.is_over(connections=0, requests=0, now_s=1001.0)


def _taken(folder: Path) -> BaseFileLock:
    lock = server_lock(folder)
    lock.acquire()
    return lock
