"""The server that Prefect starts for one run: marked, so that it can be stopped if its run was killed.

A run that is killed cannot stop its server, which then lives on for ever. So each run holds a lock file as long
as it lives (the system frees it however the process ends), and its server inherits the name of that lock in its
environment. A lock that is free although its file is there tells of a killed run; the next run on the same
home looks for the process that carries its name, and stops it. A process is known by that name and by
what it was started with, never by its id or the name of its program alone.
"""

import atexit
import importlib
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from filelock import FileLock, Timeout

MARK: Final = "TILTWATCH_SERVER_MARK"
"""Variable of the environment that a server inherits from its run."""

SERVER: Final = "prefect.server.api.server:create_app"
"""What Prefect names in the command line of its server."""

STOP_S: Final = 5.0
"""So long a server is waited for before it is killed."""

_held: list[FileLock] = []
"""The lock of this process; a process has one server, however many runs."""


def mark_server(home: Path) -> None:
    """Mark the server that this process will start, and hold the lock that says that the process lives.

    Where locks cannot be had (some network drives) nothing is marked.
    """
    if _held:
        return
    mark = secrets.token_hex(8)
    lock = FileLock(_folder(home) / f"{mark}.lock")
    try:
        Path(lock.lock_file).parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except (OSError, NotImplementedError):
        return
    _held.append(lock)
    os.environ[MARK] = mark
    # Prefect registers the end of its server later, so that comes first
    atexit.register(_forget, lock)


def stop_orphans(home: Path) -> tuple[int, ...]:
    """Stop the servers of killed runs on this home; gives the ids of the processes that were stopped."""
    stopped: list[int] = []
    for path in sorted(_folder(home).glob("*.lock")):
        with _taken_from_dead(path) as dead:
            if dead:
                stopped += _stop(_servers(path.stem))
    return tuple(stopped)


def _folder(home: Path) -> Path:
    return home / "servers"


def _forget(lock: FileLock) -> None:
    lock.release()
    with suppress(OSError):
        Path(lock.lock_file).unlink(missing_ok=True)


@contextmanager
def _taken_from_dead(path: Path) -> Iterator[bool]:
    """Hold the lock of a run if it is free, so that no one else looks for its server; then it is removed."""
    lock = FileLock(path)
    try:
        lock.acquire(timeout=0)
    except (Timeout, OSError, NotImplementedError):
        yield False
        return
    try:
        yield True
    finally:
        _forget(lock)


def _servers(mark: str) -> list[Any]:
    """Processes that were started as Prefect's server and carry the mark."""
    try:
        psutil = importlib.import_module("psutil")
    except ImportError:
        return []
    found = []
    for process in psutil.process_iter(["cmdline"]):
        if SERVER in (process.info["cmdline"] or ()):
            with suppress(psutil.Error, OSError):
                if process.environ().get(MARK) == mark:
                    found.append(process)
    return found


def _stop(servers: list[Any]) -> list[int]:
    if not servers:
        return []
    psutil = importlib.import_module("psutil")
    for server in servers:
        with suppress(psutil.NoSuchProcess):
            server.terminate()
    _gone, alive = psutil.wait_procs(servers, timeout=STOP_S)
    for server in alive:
        with suppress(psutil.NoSuchProcess):
            server.kill()
    return [server.pid for server in servers]
