"""The workflow server of a workspace: ``python -P -m flows.workflow_server``, one request on the last word.

Prefect's own server, on loopback, with a secret, without its pages. It ends by itself: when nobody was connected for a
while, when another took its place, and at once when the folder of the workspace is gone. Who uses it holds a
connection, which the system closes however that process ends; so a server is no one's orphan.
"""
# ruff: noqa: PLC0415 (Prefect's server takes seconds to import, and who started this one waits for its port)

import json
import os
import socket
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from filelock import FileLock, Timeout

LOOPBACK: Final = "127.0.0.1"
"""Nothing beyond this machine is listened to."""

FOR_EVER_S: Final = 10**9
"""The server closes no connection by itself: that of a run says that the run is there."""

LOOK_EVERY_S: Final = 0.5
"""So often a server looks whether it is still wanted."""

FIRST_USE_S: Final = 60.0
"""So long a server waits for whoever started it, however short it is kept after its last use."""

SECRET_VARIABLE: Final = "PREFECT_SERVER_API_AUTH_STRING"  # noqa: S105 (its name)
"""Where a server finds its secret: not on its command line, which everybody on the machine may read."""


@dataclass(frozen=True, slots=True)
class ServerRequest:
    """What server to be: of which folder, known by which mark, on which port (0: a free one), kept how long unused."""

    folder: str
    mark: str
    keep_s: float
    port: int = 0


@dataclass(frozen=True, slots=True)
class ServerRecord:
    """What runs must know of a server to use it; it holds the secret, and so only its owner may read it."""

    mark: str
    version: str
    folder: str
    pid: int
    port: int
    secret: str

    @property
    def url(self) -> str:
        """Address of its API."""
        return f"http://{LOOPBACK}:{self.port}/api"


def record_file(folder: Path) -> Path:
    """Where the record of the server of a folder lies."""
    return folder / "server.json"


def server_lock(folder: Path) -> FileLock:
    """Held by who looks for the server of a folder, starts one, or ends."""
    return FileLock(folder / "server.lock")


def version_of_servers() -> str:
    """What must be the same for a run to use a server: the form of the record, Prefect, and the interpreter."""
    from importlib.metadata import version

    return f"1, prefect {version('prefect')}, {sys.executable}"


def read_record(folder: Path) -> ServerRecord | None:
    """Read the record of a folder's server; None where there is none that this version understands."""
    try:
        return ServerRecord(**json.loads(record_file(folder).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def _write_record(folder: Path, record: ServerRecord) -> None:
    temp = record_file(folder).with_suffix(f".{record.mark}")
    with os.fdopen(os.open(temp, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w") as file:
        file.write(json.dumps(asdict(record)))
    temp.replace(record_file(folder))


def _listening_socket(port: int) -> socket.socket:
    made = socket.socket()
    if os.name != "nt":  # there it would let two servers have one port
        # a server that takes the place of one that died has its port, which the system holds back for a while
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    made.bind((LOOPBACK, port))
    return made


@dataclass(slots=True)
class Use:
    """Whether a server is still wanted, from what is seen of it again and again; times of one clock, seconds."""

    request: ServerRequest
    unused_since_s: float
    was_used: bool = False
    requests: int = 0
    looked_s: float = 0.0

    def is_over(self, connections: int, requests: int, now_s: float) -> bool:
        """Whether the server has to end; its record is gone then, so that nobody comes to it any more."""
        if connections or requests != self.requests:
            self.was_used, self.unused_since_s, self.requests = True, now_s, requests
        if now_s - self.looked_s < LOOK_EVERY_S:
            return False
        self.looked_s = now_s
        folder = Path(self.request.folder)
        if not folder.is_dir():
            return True
        return not connections and self._is_too_old(folder, now_s) and _withdrawn(folder, self.request.mark)

    def _is_too_old(self, folder: Path, now_s: float) -> bool:
        record = read_record(folder)
        if record is None or record.mark != self.request.mark:
            return True
        keep_s = self.request.keep_s if self.was_used else max(self.request.keep_s, FIRST_USE_S)
        return now_s - self.unused_since_s >= keep_s


def _withdrawn(folder: Path, mark: str) -> bool:
    """Take the record away, unless somebody is just about to use it."""
    try:
        with server_lock(folder).acquire(timeout=0):
            record = read_record(folder)
            if record is not None and record.mark == mark:
                record_file(folder).unlink(missing_ok=True)
    except Timeout:
        return False
    except (OSError, NotImplementedError):
        # a drive that became read-only or went: who would use the server has to take this lock first, and cannot
        return True
    return True


def serve(request: ServerRequest) -> None:
    """Be the server of a folder until it is not wanted any more."""
    listening = _listening_socket(request.port)
    port = int(listening.getsockname()[1])
    sys.stdout.write(f"{port}\n")
    sys.stdout.flush()
    # who started it reads no further line: what is written from now on belongs into the log
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    secret = os.environ[SECRET_VARIABLE]
    record = ServerRecord(request.mark, version_of_servers(), request.folder, os.getpid(), port, secret)
    server = _server(request, record)
    server.run(sockets=[listening])


def _server(request: ServerRequest, record: ServerRecord) -> Any:
    import uvicorn
    from prefect.server.api.server import create_app

    class Kept(uvicorn.Server):
        """A server that puts its record down when it is ready, and ends when it is not wanted any more."""

        use = Use(request, time.monotonic())

        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            _write_record(Path(request.folder), record)
            await super().startup(sockets)
            self.use.unused_since_s = time.monotonic()

        async def on_tick(self, counter: int) -> bool:
            state = self.server_state
            over = self.use.is_over(len(state.connections), state.total_requests, time.monotonic())
            return await super().on_tick(counter) or over

    config = uvicorn.Config(
        create_app(),
        log_level="error",
        lifespan="on",
        timeout_keep_alive=FOR_EVER_S,
        timeout_graceful_shutdown=5,
    )
    return Kept(config)


def main(words: Sequence[str]) -> None:
    """Serve what the last word asks for."""
    serve(ServerRequest(**json.loads(words[-1])))


if __name__ == "__main__":
    main(sys.argv)
