"""Settings of Prefect for one workspace, made before Prefect is imported: its own home and server, quiet, no telemetry."""

import atexit
import hashlib
import math
import os
import re
import secrets
import shutil
import socket
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Thread
from typing import Final

from flows.kept_server import NoServerError, ServerSearch, keep_alive
from flows.old_homes import sweep_old_homes
from flows.server_address import ADDRESS, check_server_address
from flows.terminal import note
from flows.workflow_server import SECRET_VARIABLE, version_of_servers
from storage.errors import UsageError
from storage.workspace import Workspace

SECRET: Final = "PREFECT_API_AUTH_STRING"  # noqa: S105 (its name)

OWN_ADDRESS: Final = "TILTWATCH_SERVER"
"""Address of the server that belongs to the workspace; children inherit it, and so know it from one that a user named."""

OWN_SERVER: Final = "own"
"""Stands for the server that runs of a workspace start for themselves; its database lies in the workspace."""

KEEP_VARIABLE: Final = "TILTWATCH_KEEP_SERVER_S"
"""Stands above keep_server_s of the campaign file: for tests and machines that must be left empty."""

_followed: dict[str, Thread] = {}
"""Who looks after the server of a home that this process uses; it is used until the process ends."""


@dataclass(frozen=True, slots=True)
class Engine:
    """The workflow engine of a run: Prefect may be imported, and before its first flow the server be waited for."""

    search: ServerSearch | None
    keep_s: float

    def wait(self) -> None:
        """Wait for the server; where it does not come up, for one of this process alone."""
        if self.search is None:
            return
        try:
            _follow(self.search, self.keep_s)
        except NoServerError as fault:
            private = _private_search(fault)
            if private is not None:
                _follow_or_leave_it_to_prefect(private)


def _follow(search: ServerSearch, keep_s: float) -> None:
    lease = search.wait()
    _followed[lease.record.folder] = keep_alive(lease, keep_s)


def _follow_or_leave_it_to_prefect(search: ServerSearch) -> None:
    try:
        _follow(search, 0.0)
    except NoServerError as fault:
        _use_none(fault)


def prepare_prefect(workspace: Workspace, keep_server_s: float) -> Engine:
    """Point Prefect to the workspace and its server, which is found, or begins to start.

    A server that the user names by PREFECT_API_URL is used; otherwise the workspace has one of its own on loopback, which
    outlives the run by ``keep_server_s``. What the user set in the environment wins. The records of stages are in the
    workspace in any case: the flow says so itself.

    Raises
    ------
    UsageError
        If ``TILTWATCH_KEEP_SERVER_S`` is no number of seconds.
    """
    keep_s = _kept_for(keep_server_s)
    take_home(workspace)
    home = Path(os.environ["PREFECT_HOME"]).expanduser().resolve()
    if users_server() is not None or _is_in_use(home):
        return Engine(None, keep_s)
    try:
        search = ServerSearch(home, keep_s)
    except NoServerError as fault:
        return Engine(_private_search(fault), 0.0)
    if not search.is_up:
        note("starting the workflow engine: some seconds")
        sweep_old_homes(workspace.prefect.resolve(), home)
    _point_to(search.record.url, search.record.secret)
    return Engine(search, keep_s)


def check_environment() -> None:
    """Look at the variables of the environment that a run may need later.

    Raises
    ------
    UsageError
        If ``TILTWATCH_KEEP_SERVER_S`` is no number of seconds, or the server that the user named none to be used.
    """
    _kept_for(0.0)
    check_server_address(users_server())


def take_home(workspace: Workspace) -> None:
    """Let Prefect, which reads its settings when it is imported, be at home in the workspace, and quiet."""
    for name, value in _defaults(workspace.prefect / _own_home()).items():
        os.environ.setdefault(name, value)


def _own_home() -> str:
    """Name of the home of this machine and version: servers of two of them must not meet on one record and database."""
    host = re.sub(r"[^A-Za-z0-9.-]", "-", socket.gethostname()) or "host"
    return f"{host}-{hashlib.sha256(version_of_servers().encode()).hexdigest()[:8]}"


def _kept_for(keep_server_s: float) -> float:
    text = os.environ.get(KEEP_VARIABLE)
    if not text:
        return keep_server_s
    try:
        keep_s = float(text)
    except ValueError:
        keep_s = math.nan
    if not 0.0 <= keep_s < math.inf:
        raise UsageError(
            f"{KEEP_VARIABLE} is {text!r}; give it seconds from 0 on, as 600, or leave it out of the environment"
        )
    return keep_s


def _private_search(fault: NoServerError) -> ServerSearch | None:
    """Begin to start a server for this process alone, in a folder that goes with it; None where Prefect is to do it.

    The server sees by its connection when this process ends, however it does; one that Prefect starts is left behind by
    a process that is killed.
    """
    try:
        folder = Path(tempfile.mkdtemp(prefix="tiltwatch-engine-"))
    except OSError:
        _use_none(fault)
        return None
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    try:
        search = ServerSearch(folder, 0.0)
    except NoServerError:
        _use_none(fault)
        return None
    note(f"the workspace has no workflow server to keep: {fault}; this run has one for itself")
    os.environ["PREFECT_HOME"] = str(folder)
    _point_to(search.record.url, search.record.secret)
    return search


def users_server() -> str | None:
    """Address of the server that the user named; None where runs have their own."""
    address = os.environ.get(ADDRESS)
    return None if not address or address == os.environ.get(OWN_ADDRESS) else address


def _is_in_use(home: Path) -> bool:
    follower = _followed.get(str(home))
    return follower is not None and follower.is_alive() and ADDRESS in os.environ


def _use_none(fault: NoServerError) -> None:
    note(f"no workflow server can be started: {fault}; this run leaves that to Prefect")
    for name in (ADDRESS, OWN_ADDRESS):
        os.environ.pop(name, None)
    # Prefect's own server inherits it and asks for it: other users of this machine reach it, too
    os.environ[SECRET] = os.environ[SECRET_VARIABLE] = f"tiltwatch:{secrets.token_urlsafe(24)}"
    _let_prefect_read()


def _point_to(address: str, secret: str) -> None:
    os.environ.update({ADDRESS: address, SECRET: secret, OWN_ADDRESS: address})
    _let_prefect_read()


def _let_prefect_read() -> None:
    """Prefect reads its settings when it is imported; in a notebook that was before."""
    if "prefect" in sys.modules:
        from prefect.context import refresh_global_settings_context  # noqa: PLC0415

        refresh_global_settings_context()


def _defaults(home: Path) -> Mapping[str, str]:
    return {
        "PREFECT_HOME": str(home),
        "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
        "DO_NOT_TRACK": "1",
        # a loaded machine needs longer than the 20 seconds that Prefect gives its own server
        "PREFECT_SERVER_EPHEMERAL_STARTUP_TIMEOUT_SECONDS": "120",
        # failures reach the user through the ledger; Prefect's own lines would only repeat them
        "PREFECT_LOGGING_LEVEL": "CRITICAL",
        "PREFECT_SERVER_LOGGING_LEVEL": "CRITICAL",
        "PREFECT_LOGGING_TO_API_ENABLED": "false",
        "PREFECT_CLI_PROMPT": "false",
        "RAY_USAGE_STATS_ENABLED": "0",
    }
