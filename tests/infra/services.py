"""PostgreSQL, a Prefect server on it, and a worker, each a process that a test may kill; stopped by their ids."""

import os
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import psutil

from tests.shared import unavailable

START_S = 120.0
STOP_S = 20.0
PASSWORD = "not-a-secret"  # noqa: S105 (of a database that lives for one test on loopback)
SECRET = "admin:not-a-secret-either"  # noqa: S105


def binaries() -> Path:
    """Folder of PostgreSQL's programs; without them the test is skipped, but not in CI, which installs them."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), key=lambda path: int(path.parts[-3]))
    if found:
        return found[-1].parent
    on_path = shutil.which("initdb")
    if on_path is None:
        unavailable(
            "no PostgreSQL programs here (Debian: apt-get install postgresql; .ci/run does where it may)"
        )
    return Path(on_path).resolve().parent


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@dataclass
class Service:
    """A process that may be killed and started again; its messages go to a file."""

    name: str
    command: list[str]
    log: Path
    ready: Callable[[], bool]
    environment: Mapping[str, str] = field(default_factory=lambda: dict(os.environ))
    user: str | None = None
    folder: Path | None = None
    process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        deadline = time.monotonic() + START_S
        while time.monotonic() < deadline:
            if self.process is None or self.process.poll() is not None:
                # a database whose children still end refuses to start: again until the time is over
                self.process = self._begin()
            if self.ready():
                return
            time.sleep(0.2)
        raise RuntimeError(f"{self.name} was not ready within {START_S} s:\n{self.messages()}")

    def _begin(self) -> "subprocess.Popen[bytes]":
        with self.log.open("ab") as out:
            return subprocess.Popen(
                self.command,
                env=dict(self.environment),
                cwd=self.folder,
                stdout=out,
                stderr=subprocess.STDOUT,
                **({} if self.user is None else {"user": self.user, "group": self.user, "extra_groups": []}),
            )

    def kill(self, *, with_children: bool = False) -> None:
        """kill -9, with all that it started where asked: as a machine does that loses its power."""
        assert self.process is not None
        children = psutil.Process(self.process.pid).children(recursive=True) if with_children else []
        self.process.kill()
        for child in children:
            with suppress(psutil.NoSuchProcess):
                child.kill()
        self.process.wait(STOP_S)

    def stop(self, sign: signal.Signals = signal.SIGTERM) -> None:
        if self.process is None:
            return
        with suppress(psutil.NoSuchProcess):
            children = psutil.Process(self.process.pid).children(recursive=True)
            self.process.send_signal(sign)
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(STOP_S)
            for child in children:
                with suppress(psutil.NoSuchProcess):
                    child.kill()
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait(STOP_S)

    def messages(self) -> str:
        return self.log.read_text(errors="replace")[-3000:] if self.log.exists() else ""


@contextmanager
def postgres(folder: Path) -> Iterator[tuple[Service, str]]:
    """A throw-away cluster on a free port of loopback; gives its process and the URL for Prefect.

    initdb refuses root, so the account postgres (or nobody) does it, in a folder of its own: those of tests
    may be entered by their owner alone.
    """
    programs = binaries()
    home = Path(tempfile.mkdtemp(prefix="tiltwatch-pg-"))
    account = _account()
    try:
        if account is not None:
            shutil.chown(home, account, account)
        service, url = _cluster(programs, home, folder, account)
        try:
            yield service, url
        finally:
            service.stop(signal.SIGINT)
    finally:
        shutil.rmtree(home, ignore_errors=True)


def _account() -> str | None:
    if os.geteuid() != 0:
        return None
    names = {entry.pw_name for entry in pwd.getpwall()}
    return "postgres" if "postgres" in names else "nobody"


def _cluster(programs: Path, home: Path, folder: Path, account: str | None) -> tuple[Service, str]:
    who = {} if account is None else {"user": account, "group": account, "extra_groups": []}
    environment = {"PATH": os.environ["PATH"], "LC_ALL": "C.UTF-8", "HOME": str(home)}
    secret = home / "secret"
    secret.write_text(PASSWORD)
    secret.chmod(0o644)
    made = subprocess.run(
        [
            programs / "initdb",
            "-D",
            home / "data",
            "-U",
            "prefect",
            "-A",
            "scram-sha-256",
            f"--pwfile={secret}",
        ],
        capture_output=True,
        text=True,
        timeout=START_S,
        check=False,
        cwd=home,
        env=environment,
        **who,
    )
    assert made.returncode == 0, made.stderr
    port = free_port()
    command = [str(programs / "postgres"), "-D", str(home / "data"), "-h", "127.0.0.1", "-p", str(port)]
    command += ["-c", f"unix_socket_directories={home}", "-c", "max_connections=50"]
    asked = [programs / "pg_isready", "-h", "127.0.0.1", "-p", str(port), "-q"]

    def ready() -> bool:
        return subprocess.run(asked, check=False, timeout=10).returncode == 0

    service = Service("PostgreSQL", command, folder / "postgres.log", ready, environment, account, home)
    try:
        service.start()
    except BaseException:
        service.stop(signal.SIGINT)
        raise
    return service, f"postgresql+asyncpg://prefect:{PASSWORD}@127.0.0.1:{port}/postgres"


@contextmanager
def server_on(database: str, home: Path) -> Iterator[tuple[Service, str]]:
    """A Prefect server on a database, with a shared secret; gives its process and the URL of its API."""
    port = free_port()
    home.mkdir(parents=True, exist_ok=True)
    api = f"http://127.0.0.1:{port}/api"
    environment = {
        **os.environ,
        "PREFECT_HOME": str(home),
        "PREFECT_SERVER_DATABASE_CONNECTION_URL": database,
        "PREFECT_SERVER_API_AUTH_STRING": SECRET,
        # else a server that is killed forgets who holds the slots of deployments
        "PREFECT_SERVER_CONCURRENCY_LEASE_STORAGE": "prefect.server.concurrency.lease_storage.filesystem",
        "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
        "PREFECT_LOGGING_LEVEL": "WARNING",
        "DO_NOT_TRACK": "1",
    }
    command = [sys.executable, "-m", "prefect", "server", "start", "--host", "127.0.0.1", "--port", str(port)]
    service = Service(
        "Prefect's server", command, home / "server.log", lambda: answers(f"{api}/health"), environment
    )
    try:
        service.start()
        yield service, api
    finally:
        service.stop()


def answers(url: str, secret: str | None = None) -> bool:
    return status_of(url, secret) == 200


def status_of(url: str, secret: str | None = None) -> int | None:
    """Status with which a server answers; None where it does not."""
    from base64 import b64encode  # noqa: PLC0415

    request = urllib.request.Request(url)  # noqa: S310 (a server of this test on loopback)
    if secret is not None:
        request.add_header("Authorization", f"Basic {b64encode(secret.encode()).decode()}")
    try:
        with urllib.request.urlopen(request, timeout=5) as answer:  # noqa: S310
            return int(answer.status)
    except urllib.error.HTTPError as told:
        return told.code
    except OSError:
        return None
