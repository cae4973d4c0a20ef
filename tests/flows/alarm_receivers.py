"""Receivers of messages that are real servers on loopback: mail, HTTP, and a place where nobody listens."""

import json
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from email import message_from_bytes, policy
from email.message import EmailMessage
from http.server import BaseHTTPRequestHandler, HTTPServer

from aiosmtpd.controller import Controller
from aiosmtpd.smtp import SMTP, AuthResult, Envelope, LoginPassword, Session

HOST = "127.0.0.1"


@dataclass
class Mailbox:
    """Mails that arrived; ``answer`` is what the server says to the next ones."""

    port: int = 0
    mails: list[EmailMessage] = field(default_factory=list)
    logins: list[tuple[str, str]] = field(default_factory=list)
    answer: str = "250 taken"

    async def handle_DATA(self, _server: SMTP, _session: Session, envelope: Envelope) -> str:  # noqa: N802
        if self.answer.startswith("250"):
            self.mails.append(message_from_bytes(envelope.original_content or b"", policy=policy.default))
        return self.answer

    def login(
        self, _server: SMTP, _session: Session, _envelope: Envelope, _mechanism: str, data: object
    ) -> AuthResult:
        if isinstance(data, LoginPassword):
            self.logins.append((data.login.decode(), data.password.decode()))
        return AuthResult(success=data == LoginPassword(b"bell", b"s3cret-word"), handled=False)


@contextmanager
def mail_server(*, with_login: bool = False) -> Iterator[Mailbox]:
    """A mail server on loopback; with a login it takes only user bell with password s3cret-word."""
    box = Mailbox()
    asked = (
        {"authenticator": box.login, "auth_required": True, "auth_require_tls": False} if with_login else {}
    )
    controller = Controller(box, hostname=HOST, port=free_port(), ready_timeout=30.0, **asked)
    controller.start()
    try:
        box.port = controller.port
        yield box
    finally:
        controller.stop()


@dataclass
class Desk:
    """Requests that arrived; ``status`` is what the server answers."""

    port: int = 0
    posts: list[dict[str, str]] = field(default_factory=list)
    status: int = 200


@contextmanager
def http_server() -> Iterator[Desk]:
    """An HTTP server on loopback that keeps the JSON of every request."""
    desk = Desk()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            if desk.status == 200:
                desk.posts.append(json.loads(body))
            self.send_response(desk.status)
            self.end_headers()

        def log_message(self, *_words: object) -> None:
            """Say nothing."""

    server = HTTPServer((HOST, 0), Handler)
    desk.port = server.server_port
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    try:
        yield desk
    finally:
        server.shutdown()
        thread.join(timeout=30.0)
        server.server_close()


def free_port() -> int:
    """A port on loopback where nobody listens."""
    with socket.socket() as place:
        place.bind((HOST, 0))
        return int(place.getsockname()[1])
