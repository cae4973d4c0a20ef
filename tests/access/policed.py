"""An S3 server that holds every request against a policy of infra/, before it lets it through to the real one."""

import fnmatch
import http.client
import json
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import parse_qs, unquote, urlsplit

INFRA = Path(__file__).resolve().parents[2] / "infra"


@dataclass(frozen=True)
class Asked:
    """What a request needs leave for; ``prefix`` is that of a listing."""

    action: str
    resource: str
    prefix: str | None = None


@dataclass
class Police:
    """A policy, and what was asked under it."""

    statements: list[Mapping[str, Any]]
    url: str = ""
    asked: list[Asked] = field(default_factory=list)
    refused: list[Asked] = field(default_factory=list)

    def allows(self, asked: Asked) -> bool:
        self.asked.append(asked)
        if any(_fits(statement, asked) for statement in self.statements):
            return True
        self.refused.append(asked)
        return False


def policy(role: str, bucket: str, prefix: str) -> Police:
    text = (INFRA / f"object-store-{role}.json").read_text(encoding="utf-8")
    return Police(json.loads(text.replace("BUCKET", bucket).replace("PREFIX", prefix))["Statement"])


def _fits(statement: Mapping[str, Any], asked: Asked) -> bool:
    actions = statement["Action"] if isinstance(statement["Action"], list) else [statement["Action"]]
    if statement["Effect"] != "Allow" or asked.action not in actions:
        return False
    if not fnmatch.fnmatchcase(asked.resource, statement["Resource"]):
        return False
    prefixes = statement.get("Condition", {}).get("StringLike", {}).get("s3:prefix")
    if prefixes is None:
        return True
    return asked.prefix is not None and any(fnmatch.fnmatchcase(asked.prefix, one) for one in prefixes)


def needed_for(method: str, address: str, headers: Mapping[str, str]) -> list[Asked]:
    """What Amazon asks leave for at a request."""
    parts = urlsplit(address)
    bucket, _, key = unquote(parts.path).lstrip("/").partition("/")
    query = parse_qs(parts.query, keep_blank_values=True)
    resource = f"arn:aws:s3:::{bucket}" + (f"/{key}" if key else "")
    if not key:
        if method in ("GET", "HEAD"):
            return [Asked("s3:ListBucket", resource, query.get("prefix", [None])[0])]
        return [Asked("s3:DeleteObject" if "delete" in query else "s3:CreateBucket", f"{resource}/*")]
    if method == "DELETE":
        return [Asked("s3:AbortMultipartUpload" if "uploadId" in query else "s3:DeleteObject", resource)]
    needed = [Asked("s3:GetObject" if method in ("GET", "HEAD") else "s3:PutObject", resource)]
    source = headers.get("x-amz-copy-source")
    return needed + ([Asked("s3:GetObject", f"arn:aws:s3:::{unquote(source).lstrip('/')}")] if source else [])


def _body(file: BinaryIO, headers: Mapping[str, str]) -> bytes:
    """The body of a request as it came, with the lengths of its chunks where it has chunks."""
    if "chunked" not in headers.get("Transfer-Encoding", ""):
        return file.read(int(headers.get("Content-Length", 0)))
    body = b""
    while True:
        head = file.readline()
        size = int(head.split(b";")[0], 16)
        body += head + file.read(size + 2)
        if size == 0:
            return body


class _Checked(BaseHTTPRequestHandler):
    """Lets through what the police allows, and answers the rest as Amazon does."""

    protocol_version = "HTTP/1.1"
    police: Police
    behind: str

    def _pass(self) -> None:
        body = _body(self.rfile, self.headers)
        needed = needed_for(self.command, self.path, self.headers)
        if any([not self.police.allows(asked) for asked in needed]):  # noqa: C419 (each is put down)
            self._answer(403, {}, b"<Error><Code>AccessDenied</Code><Message>no</Message></Error>")
            return
        connection = http.client.HTTPConnection(self.behind, timeout=30)
        connection.putrequest(self.command, self.path, skip_host=True, skip_accept_encoding=True)
        for name, value in self.headers.items():
            if name.lower() != "expect":
                connection.putheader(name, value)
        connection.endheaders(body)
        came = connection.getresponse()
        content = came.read()
        self._answer(came.status, dict(came.headers), content)
        connection.close()

    def _answer(self, status: int, headers: Mapping[str, str], content: bytes) -> None:
        self.send_response_only(status)
        for name, value in headers.items():
            if name.lower() not in ("transfer-encoding", "connection", "content-length"):
                self.send_header(name, value)
        length = headers.get("Content-Length", "0") if self.command == "HEAD" else len(content)
        self.send_header("Content-Length", str(length))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    do_GET = do_HEAD = do_PUT = do_POST = do_DELETE = _pass  # noqa: N815 (names of the library)

    def log_message(self, *_words: object) -> None:
        """Say nothing."""


@contextmanager
def policed(server: str, police: Police) -> Iterator[Police]:
    """Put the police before a server."""
    told = {"police": police, "behind": server.removeprefix("http://")}
    proxy = ThreadingHTTPServer(("127.0.0.1", 0), type("Checked", (_Checked,), told))
    proxy.daemon_threads = True
    thread = threading.Thread(target=proxy.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
    thread.start()
    police.url = f"http://127.0.0.1:{proxy.server_port}"
    try:
        yield police
    finally:
        proxy.shutdown()
        proxy.server_close()
        thread.join(timeout=10)
