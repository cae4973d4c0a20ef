"""An upload server for tests, and requests of its protocol by hand and by a client."""

import base64
import http.client
import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from tusclient.client import TusClient

from flows.upload.server import Listening, upload_server

TOKEN = "only-for-this-test-0123"  # noqa: S105 (it opens nothing)


CONTENT = np.random.default_rng(3).bytes(300_000)


@contextmanager
def serving(inbox: Path, **changes: object) -> Iterator[str]:
    """URL of an upload server."""
    wanted = Listening(**{"host": "127.0.0.1", "port": 0, "token": TOKEN, **changes})  # type: ignore[arg-type]
    inbox.mkdir(exist_ok=True)
    with upload_server(inbox, wanted, lambda _name, _size: None) as port:
        yield f"http://127.0.0.1:{port}/files/"


def client(url: str, token: str = TOKEN) -> TusClient:
    return TusClient(url, headers={"Authorization": f"Bearer {token}"})


def scan_file(folder: Path, content: bytes = CONTENT) -> Path:
    path = folder / "to-send.laz"
    path.write_bytes(content)
    return path


def send(url: str, path: Path, name: str = "ST01.laz", **metadata: str) -> None:
    client(url).uploader(
        file_stream=io.BytesIO(path.read_bytes()), chunk_size=100_000, metadata={"filename": name, **metadata}
    ).upload()


def ask(
    url: str, method: str, headers: dict[str, str], body: bytes | None = None
) -> http.client.HTTPResponse:
    """One request of the protocol, by hand."""
    host, _, path = url.removeprefix("http://").partition("/")
    connection = http.client.HTTPConnection(host, timeout=30)
    always = {"Tus-Resumable": "1.0.0", "Authorization": f"Bearer {TOKEN}"}
    connection.request(method, f"/{path}", body, {**always, **headers})
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer


def metadata_of(**values: str) -> str:
    return ",".join(f"{key} {base64.b64encode(value.encode()).decode()}" for key, value in values.items())


def begun(url: str, size: int, name: str = "ST01.laz", **headers: str) -> http.client.HTTPResponse:
    wanted = {"Upload-Length": str(size), "Upload-Metadata": metadata_of(filename=name), **headers}
    return ask(url, "POST", wanted)


def files(inbox: Path) -> list[str]:
    return sorted(path.name for path in inbox.iterdir() if not path.name.startswith("."))


def half_a_patch(url: str, body: bytes, total: int) -> http.client.HTTPConnection:
    """Begin to send, and say no more; the connection stays open."""
    host, _, path = url.removeprefix("http://").partition("/")
    connection = http.client.HTTPConnection(host, timeout=30)
    connection.putrequest("PATCH", f"/{path}")
    for key, value in {
        "Tus-Resumable": "1.0.0",
        "Authorization": f"Bearer {TOKEN}",
        "Upload-Offset": "0",
        "Content-Type": "application/offset+octet-stream",
        "Content-Length": str(total),
    }.items():
        connection.putheader(key, value)
    connection.endheaders()
    connection.send(body)
    return connection
