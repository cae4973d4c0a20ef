"""Find the workflow server of a folder or start it, and hold a connection that says that this process uses it.

A server takes seconds to start, so one run leaves it to the next (flows/workflow_server.py says when it ends). Where it
dies under a run, the run starts another on the same port: Prefect's client asks again until it answers.
"""

import base64
import http.client
import json
import os
import secrets
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextvars import copy_context
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from flows.server_check import why_it_cannot_write
from flows.server_folder import make_fit, make_private
from flows.terminal import note
from flows.workflow_server import (
    LOOPBACK,
    SECRET_VARIABLE,
    ServerRecord,
    ServerRequest,
    read_record,
    server_lock,
    version_of_servers,
)
from storage.errors import StorageError, TiltwatchError

ROOT: Final = Path(__file__).resolve().parents[1]

START_S: Final = 120.0
"""Longest wait for a server; a loaded machine needs a minute."""

ANSWER_S: Final = 10.0
"""Longest wait for the answer of a server that is there."""

LOOK_EVERY_S: Final = 0.05

LOG: Final = "server.log"

UNUSED_SERVICES: Final = (
    "CANCELLATION_CLEANUP",
    "CLEANUP_RECONCILER",
    "EVENT_PERSISTER",
    "FOREMAN",
    "LATE_RUNS",
    "PAUSE_EXPIRATIONS",
    "REPOSSESSOR",
    "SCHEDULER",
    "TASK_RUN_RECORDER",
    "TRIGGERS",
)
"""Services of Prefect's server for schedules, workers, automations and events, none of which a workspace has."""

OK: Final = 200
UNAUTHORIZED: Final = 401

_started: Final[list["subprocess.Popen[bytes]"]] = []
"""Servers that this process started; they outlive it."""


class NoServerError(TiltwatchError):
    """No server could be found or started."""


@dataclass(frozen=True, slots=True)
class Lease:
    """A connection to a server, which tells it that it is used, and this process when it ended."""

    record: ServerRecord
    connection: http.client.HTTPConnection

    def wait_for_end(self) -> None:
        """Wait until the server closes the connection: it does so when it ends, and never before."""
        made = self.connection.sock
        try:
            made.settimeout(None)
            while made.recv(1024):
                pass
        except OSError:
            pass  # that is an end, too
        finally:
            self.connection.close()


def lease_of(record: ServerRecord) -> Lease | None:
    """Connect to the server of a record; None where it is gone, or something else that does not know the secret answers."""
    connection = http.client.HTTPConnection(LOOPBACK, record.port, timeout=ANSWER_S)
    secret = base64.b64encode(record.secret.encode()).decode()
    try:
        # another server on that port may answer anything; only one that asks for a secret is told it
        known = _asked(connection, {}).status == UNAUTHORIZED
        answer = _asked(connection, {"Authorization": f"Basic {secret}"}) if known else None
    except (OSError, http.client.HTTPException):
        connection.close()
        return None
    is_ours = answer is not None and answer == _Answer(OK, json.dumps(version("prefect")).encode())
    if not is_ours or connection.sock is None:
        connection.close()
        return None
    return Lease(record, connection)


@dataclass(frozen=True, slots=True)
class _Answer:
    status: int
    body: bytes


def _asked(connection: http.client.HTTPConnection, headers: Mapping[str, str]) -> _Answer:
    """Ask for the version of the server."""
    connection.request("GET", "/api/admin/version", headers=dict(headers))
    answer = connection.getresponse()
    return _Answer(answer.status, answer.read().strip())


class ServerSearch:
    """A server that was found or is on its way up; until ``wait`` is called nobody else finds or starts one."""

    def __init__(self, folder: Path, keep_s: float, instead_of: ServerRecord | None = None) -> None:
        """Find the server of a folder, or begin to start one.

        Parameters
        ----------
        folder
            PREFECT_HOME of the server.
        keep_s
            So long it is kept after its last use, seconds.
        instead_of
            A server that died, whose port and secret the new one takes.

        Raises
        ------
        NoServerError
            If that cannot be done; where locks cannot be had (some network drives), for one.
        """
        self._lock = _taken_lock(folder)
        try:
            found = read_record(folder)
            known = found is not None and (found.version, found.folder) == (version_of_servers(), str(folder))
            self._lease = lease_of(found) if known and found is not None else None
            self._process: subprocess.Popen[bytes] | None = None
            if self._lease is None:
                self._process, self.record = _start(folder, keep_s, instead_of)
            else:
                self.record = self._lease.record
        except BaseException:
            self._lock.release()
            raise

    @property
    def is_up(self) -> bool:
        """Whether the server was found, and need not be waited for."""
        return self._lease is not None

    def wait(self) -> Lease:
        """Wait until the server answers.

        Raises
        ------
        NoServerError
            If it ends, does not answer within two minutes, or can write nothing down.
        """
        try:
            if self._process is not None and self._lease is None:
                self._lease = _when_it_answers(self._process, self.record)
            check_writes(self._lease)
        except BaseException:
            if self._process is not None:
                self._process.terminate()
            raise
        finally:
            self._lock.release()
        if self._lease is None:
            raise NoServerError("nobody started it")
        return self._lease


def check_writes(lease: Lease | None) -> None:
    """Leave a server that cannot write anything down, and say why."""
    why_not = None if lease is None else why_it_cannot_write(lease.record)
    if lease is not None and why_not is not None:
        lease.connection.close()
        raise NoServerError(why_not)


def _when_it_answers(process: "subprocess.Popen[bytes]", record: ServerRecord) -> Lease:
    deadline = time.monotonic() + START_S
    while process.poll() is None and time.monotonic() < deadline:
        time.sleep(LOOK_EVERY_S)
        lease = lease_of(record)
        if lease is not None:
            return lease
    raise NoServerError(_why(Path(record.folder), ended=process.poll() is not None))


def keep_alive(lease: Lease, keep_s: float) -> threading.Thread:
    """Look after a server as long as this process lives: where it dies, start another in its place.

    Returns
    -------
    Thread
        Who does so; it ends where there is no server any more.
    """

    def follow() -> None:
        present = lease
        while True:
            present.wait_for_end()
            folder = Path(present.record.folder)
            if not folder.is_dir():
                return
            note("the workflow server died; another takes its place")
            try:
                present = ServerSearch(folder, keep_s, instead_of=present.record).wait()
            except (NoServerError, OSError) as fault:
                note(f"no workflow server any more: {fault}")
                return
            if present.record.url != lease.record.url:
                # Prefect asks at the address that it began with
                note(
                    "another run has started one elsewhere; this run goes on without, run it again if it fails"
                )
                return

    context = copy_context()
    thread = threading.Thread(target=context.run, args=(follow,), name="workflow-server", daemon=True)
    thread.start()
    return thread


def _taken_lock(folder: Path) -> FileLock:
    try:
        make_private(folder)
        lock = server_lock(folder)
        lock.acquire(timeout=START_S)
    except Timeout:
        raise NoServerError(
            f"another process holds {folder / 'server.lock'} for more than {START_S:.0f} s"
        ) from None
    except (OSError, NotImplementedError, StorageError) as fault:
        raise NoServerError(f"no lock in {folder}: {fault}") from fault
    return lock


def _start(
    folder: Path, keep_s: float, instead_of: ServerRecord | None
) -> tuple["subprocess.Popen[bytes]", ServerRecord]:
    """Start a server apart from this process; it tells its port at once, and answers after seconds."""
    make_fit(folder)
    mark = secrets.token_hex(8)
    secret = f"tiltwatch:{secrets.token_urlsafe(24)}" if instead_of is None else instead_of.secret
    request = ServerRequest(str(folder), mark, keep_s, 0 if instead_of is None else instead_of.port)
    command = [sys.executable, "-P", "-m", "flows.workflow_server", json.dumps(asdict(request))]
    try:
        with (folder / LOG).open("wb") as log:
            process = subprocess.Popen(
                command,
                env=_environment(folder, secret),
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=log,
                **_apart(),  # type: ignore[call-overload]
            )
    except OSError as fault:
        raise NoServerError(f"it cannot be started: {fault}") from fault
    _started.append(process)
    told = _first_line(process)
    if told is None or not told.isdigit():
        process.kill()
        process.wait()
        raise NoServerError(_why(folder, ended=told is not None))
    return process, ServerRecord(mark, version_of_servers(), str(folder), process.pid, int(told), secret)


def _first_line(process: "subprocess.Popen[bytes]") -> bytes | None:
    """What a server tells first; None where it does not within two minutes."""
    told: list[bytes] = []

    def read() -> None:
        if process.stdout is not None:
            with process.stdout:
                told.append(process.stdout.readline().strip())

    # not every system can wait for a pipe with a time limit
    reader = threading.Thread(target=read, name="first-line", daemon=True)
    reader.start()
    reader.join(START_S)
    return told[0] if told else None


def _apart() -> Mapping[str, object]:
    """Ctrl-C, the end of the terminal and the end of a process group are for the run, not for its server."""
    if os.name == "nt":
        names = ("CREATE_NEW_PROCESS_GROUP", "CREATE_NO_WINDOW")
        return {"creationflags": sum(getattr(subprocess, name) for name in names)}
    return {"start_new_session": True}


def _environment(folder: Path, secret: str) -> dict[str, str]:
    ours = {
        name: value
        for name, value in os.environ.items()
        # a server outlives its run; it has no use for the keys of a store, nor for the secrets of a client
        if not name.startswith(("PREFECT__", "PREFECT_API_", "AWS_"))
    }
    path = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {
        **{f"PREFECT_SERVER_SERVICES_{service}_ENABLED": "false" for service in UNUSED_SERVICES},
        **ours,
        "PYTHONPATH": os.pathsep.join(path),
        "PREFECT_HOME": str(folder),
        "PREFECT_UI_ENABLED": "0",
        # as Prefect starts one for a single run: with fewer services
        "PREFECT__SERVER_EPHEMERAL": "1",
        "PREFECT__SERVER_FINAL": "1",
        SECRET_VARIABLE: secret,
    }


def _why(folder: Path, *, ended: bool) -> str:
    try:
        tail = (folder / LOG).read_text(encoding="utf-8", errors="replace").strip().splitlines()[-1:]
    except OSError:
        tail = []
    what = "it ended" if ended else f"it did not answer within {START_S:.0f} s"
    return ": ".join([what, *tail]) + f" ({folder / LOG})"
