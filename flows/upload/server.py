"""The upload server of a watch: uvicorn in a thread, the tus protocol behind the gate."""

import asyncio
import shutil
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import uvicorn
from fastapi import FastAPI, HTTPException
from tuspyserver import create_tus_router

from flows.upload.finish import Received, finish_all, finish_upload
from flows.upload.gate import PREFIX, Gate
from flows.upload.names import upload_name
from flows.upload.store import UploadStore
from storage.errors import InputError, StorageError, UsageError
from storage.loopback import is_loopback
from storage.secrets import check_private, secret_in

FOLDER: Final = ".uploads"
"""Hidden folder of the inbox for unfinished uploads: the same disk, so that finishing one is a rename."""

MOST_BYTES: Final = 200_000_000_000
KEEP_DAYS: Final = 30
START_S: Final = 30.0
SHORTEST_TOKEN: Final = 16
RESERVE_BYTES: Final = 1_000_000_000
"""So much of the disk is left free."""


@dataclass(frozen=True, slots=True)
class Listening:
    """Where and how uploads are taken."""

    host: str
    port: int
    token: str
    tls_cert: Path | None = None
    tls_key: Path | None = None
    max_bytes: int = MOST_BYTES


def listening(
    address: str, token_env: str | None, tls: tuple[Path | None, Path | None], *, insecure_http: bool
) -> Listening:
    """Check what the user wants of the upload server.

    Raises
    ------
    UsageError
        If the address is none, the token is missing or short, or a token would travel in clear over a network.
    InputError
        If others may read the file of the token or of the key.
    """
    host, separator, port = address.rpartition(":")
    if not separator or not host or not port.isdecimal() or int(port) > 65535:
        raise UsageError(f"--listen needs HOST:PORT, got {address!r}")
    token = (secret_in(token_env) if token_env else None) or ""
    if len(token) < SHORTEST_TOKEN:
        raise UsageError(
            f"--listen needs a token of {SHORTEST_TOKEN} characters or more in an environment variable named by "
            f"--token-env, or in a file of mode 600 that {token_env or 'NAME'}_FILE names; `openssl rand -hex 24` makes one"
        )
    cert, key = tls
    if (cert is None) != (key is None):
        raise UsageError("--tls-cert and --tls-key go together")
    for file in (cert, key):
        if file is not None and not file.is_file():
            raise UsageError(f"no file {file}; --tls-cert and --tls-key need PEM files")
    if key is not None:
        check_private(key, "--tls-key")
    bare = host.strip("[]")
    if cert is None and not insecure_http and not is_loopback(bare):
        raise UsageError(
            f"on {host} the token would travel readable for others: give --tls-cert and --tls-key, listen on 127.0.0.1 "
            "behind a proxy with TLS, or accept it with --insecure-http"
        )
    return Listening(bare, int(port), token, cert, key)


@contextmanager
def upload_server(inbox: Path, wanted: Listening, received: Received) -> Iterator[int]:
    """Take uploads into an inbox as long as the block lasts; gives the port.

    Raises
    ------
    StorageError
        If the server does not start, as where the port is taken.
    """
    store = UploadStore(inbox / FOLDER)
    finish_all(store, inbox, received)
    server = uvicorn.Server(
        uvicorn.Config(
            Gate(_application(store, inbox, wanted, received), wanted.token, wanted.max_bytes),
            host=wanted.host,
            port=wanted.port,
            lifespan="off",
            log_level="critical",
            ssl_certfile=wanted.tls_cert,
            ssl_keyfile=wanted.tls_key,
            timeout_graceful_shutdown=5,
        )
    )
    thread = threading.Thread(target=_serve, args=(server,), name="uploads", daemon=True)
    thread.start()
    try:
        yield _port_of(server, thread, wanted)
    finally:
        server.should_exit = True
        thread.join(15.0)


def _application(store: UploadStore, inbox: Path, wanted: Listening, received: Received) -> Any:
    app = FastAPI(openapi_url=None)

    async def finish(location: str, _metadata: Mapping[str, str]) -> None:
        try:
            await asyncio.to_thread(finish_upload, store, inbox, Path(location).stem, received)
        except InputError as fault:
            raise HTTPException(460, str(fault)) from fault
        except StorageError as fault:
            raise HTTPException(507, str(fault)) from fault

    def begin(metadata: Mapping[str, str], info: Mapping[str, Any]) -> None:
        _check_new(inbox, wanted, metadata, info)

    app.include_router(
        create_tus_router(
            prefix=PREFIX,
            files_dir=str(inbox / FOLDER),
            max_size=wanted.max_bytes,
            days_to_keep=KEEP_DAYS,
            # it is awaited where it is a coroutine
            on_upload_complete=finish,  # type: ignore[arg-type]
            pre_create_hook=begin,
            storage=store,
        )
    )
    return app


def _check_new(inbox: Path, wanted: Listening, metadata: Mapping[str, str], info: Mapping[str, Any]) -> None:
    size = info.get("size")
    try:
        upload_name(metadata.get("filename"))
    except InputError as fault:
        raise HTTPException(400, str(fault)) from fault
    if not isinstance(size, int) or size < 0:
        raise HTTPException(400, "needs Upload-Length, the size in bytes")
    if size > wanted.max_bytes:
        raise HTTPException(413, f"at most {wanted.max_bytes} bytes are taken")
    if shutil.disk_usage(inbox).free < size + RESERVE_BYTES:
        raise HTTPException(507, "the disk has not enough room")


def _serve(server: uvicorn.Server) -> None:
    try:
        server.run()
    except SystemExit:
        # uvicorn leaves so where it cannot bind; whoever waits for the start sees the thread end
        return


def _port_of(server: uvicorn.Server, thread: threading.Thread, wanted: Listening) -> int:
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline and thread.is_alive():
        if server.started:
            return int(server.servers[0].sockets[0].getsockname()[1])
        time.sleep(0.05)
    raise StorageError(
        f"uploads cannot be taken on {wanted.host}:{wanted.port}: the address cannot be used, or is taken; choose another"
    )
