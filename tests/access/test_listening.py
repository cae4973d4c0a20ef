"""Servers that commands start listen on this machine alone, by default; seen at the sockets of their processes."""

import contextlib
import http.client
import ipaddress
import json
import os
import socket
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest

from flows.kept_server import ServerSearch
from flows.workflow_server import record_file
from tests.flows.calls import ROOT
from tests.flows.stored_campaign import publish, stored_campaign

TOKEN = "only-for-this-test-0123"  # noqa: S105 (it opens nothing)
IDLE = 150


def listening_on(pid: int) -> set[tuple[str, int]]:
    """Addresses on which a process and all that it started take connections."""
    process = psutil.Process(pid)
    found = set()
    for one in (process, *process.children(recursive=True)):
        with contextlib.suppress(psutil.NoSuchProcess):
            found |= {tuple(c.laddr) for c in one.net_connections("inet") if c.status == psutil.CONN_LISTEN}
    return found


def assert_on_loopback_only(pid: int) -> None:
    addresses = listening_on(pid)
    assert addresses, "it listens nowhere: nothing was looked at"
    assert all(ipaddress.ip_address(host).is_loopback for host, _port in addresses), addresses


@contextmanager
def started(*words: object, **variables: str) -> Iterator["subprocess.Popen[str]"]:
    """A command as a process, ended with the block."""
    process = subprocess.Popen(
        [sys.executable, "-m", "flows.cli", *map(str, words)],
        env={**os.environ, "PYTHONPATH": str(ROOT), **variables},
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield process
    finally:
        process.terminate()
        process.communicate(timeout=30)


@pytest.fixture(scope="module")
def dashboard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[int, int]]:
    """Process and port of a dashboard that was started without a word about its address."""
    stored = stored_campaign(tmp_path_factory.mktemp("dashboard"))
    publish(stored, "e1", 0)
    with started("dashboard", stored.file, "--port", 0) as process:
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        yield process.pid, int(address.rstrip("/").rpartition(":")[2])


def asked(port: int, path: str = "/_dash-layout", **headers: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer


def test_the_dashboard_listens_on_this_machine_alone(dashboard: tuple[int, int]) -> None:
    assert_on_loopback_only(dashboard[0])


def test_who_connects_and_says_nothing_keeps_nobody_out(dashboard: tuple[int, int]) -> None:
    _pid, port = dashboard
    with contextlib.ExitStack() as stack:
        for number in range(IDLE):
            idle = stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=20))
            if number % 2:
                idle.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\nX-Slow: ")
        assert asked(port).status == 200


def test_a_request_that_is_too_large_is_refused(dashboard: tuple[int, int]) -> None:
    _pid, port = dashboard
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    connection.putrequest("POST", "/_dash-update-component")
    connection.putheader("Content-Length", str(2 << 20))
    connection.endheaders()
    assert connection.getresponse().status == 413
    connection.close()
    assert asked(port, "/", **{"X-Long": "x" * (1 << 16)}).status == 431


@pytest.mark.parametrize(
    "path",
    [
        "/assets/..%2f..%2fserver.py",
        "/assets/../../pyproject.toml",
        "/3d/static/..%2f..%2f..%2fserver.py",
        "/3d/static/%2fetc%2fpasswd",
        "/view/..%2f..%2fcatalog.csv?structure=chimney-01",
        "/view/epochs;DROP%20TABLE%20x.csv?structure=chimney-01",
        "/report/chimney-01/..%2f..%2fe1.pdf",
        "/csv/..%2fx/..%2fy",
        "/_dash-component-suites/dash/..%2f..%2f..%2fx.py",
        "/%00",
    ],
)
def test_no_path_climbs_out(dashboard: tuple[int, int], path: str) -> None:
    answer = asked(dashboard[1], path)
    kind = str(answer.headers.get("Content-Type"))
    # an unknown path is answered by the frame of all pages
    assert answer.status in (400, 404) or kind.startswith("text/html"), (answer.status, kind)


def test_its_answers_may_not_be_taken_by_other_sites(dashboard: tuple[int, int]) -> None:
    answer = asked(dashboard[1])
    assert answer.headers["Cross-Origin-Resource-Policy"] == "same-origin"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert answer.headers.get("Access-Control-Allow-Origin") is None
    assert answer.headers.get("Server") is None
    assert asked(dashboard[1], Host="rebound.example").status == 403


@pytest.mark.slow
def test_the_upload_server_listens_where_it_is_told_to_and_nowhere_else(tmp_path: Path) -> None:
    stored = stored_campaign(tmp_path)
    words = ("--inbox", tmp_path / "inbox", "--listen", "127.0.0.1:0", "--token-env", "SITE", "--json")
    with started("watch", stored.file, *words, SITE=TOKEN) as process:
        assert process.stdout is not None
        event = json.loads(process.stdout.readline())
        assert_on_loopback_only(process.pid)
        assert {port for _host, port in listening_on(process.pid)} == {event["upload_port"]}
        assert asked(event["upload_port"], "/files/").status == 401


@pytest.mark.slow
def test_the_workflow_server_listens_on_this_machine_alone_and_answers_who_has_its_secret(
    tmp_path: Path,
) -> None:
    home = tmp_path / "home"
    lease = ServerSearch(home, 0.0).wait()
    try:
        assert_on_loopback_only(lease.record.pid)
        port = lease.record.port
        assert len(lease.record.secret) >= 32
        for path in ("/api/admin/version", "/api/admin/settings", "/api/flow_runs/count"):
            assert asked(port, path).status == 401
        assert asked(port, "/api/admin/version", Authorization="Basic dGlsdHdhdGNoOg==").status == 401
        assert stat.S_IMODE(home.stat().st_mode) == 0o700
        assert stat.S_IMODE(record_file(home).stat().st_mode) == 0o600
        # the command line can be read by every user of the machine
        assert lease.record.secret not in " ".join(psutil.Process(lease.record.pid).cmdline())
    finally:
        process = psutil.Process(lease.record.pid)
        lease.connection.close()
        process.terminate()
        process.wait(60)


def test_what_others_may_do_in_the_folder_of_an_older_server_is_taken_away(tmp_path: Path) -> None:
    from flows.server_folder import make_private  # noqa: PLC0415 (one step of the start)

    home = tmp_path / "home"
    home.mkdir(mode=0o755)
    make_private(home)
    assert stat.S_IMODE(home.stat().st_mode) == 0o700
