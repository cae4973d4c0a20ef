"""The dashboard as a server: waitress on loopback; elsewhere only with a token."""

import hmac
import logging
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final
from urllib.parse import urlencode

import flask
import waitress

from dashboard.app import make_app
from dashboard.view import Site
from storage.errors import InputError, UsageError
from storage.loopback import is_loopback
from storage.workspace import Workspace

COOKIE: Final = "tiltwatch-token"
LEAST_TOKEN: Final = 16
"""Characters; a shorter token can be guessed."""

_LIMITS: Final = {
    # a page asks with some hundred bytes
    "max_request_body_size": 1 << 20,
    "max_request_header_size": 1 << 15,
    # who connects and says nothing must not keep others out, nor for long
    "connection_limit": 500,
    "channel_timeout": 30,
    "cleanup_interval": 5,
}
"""What a visitor may cost before anybody asked who he is."""

_POLICY: Final = (
    "default-src 'self'; script-src 'self' 'unsafe-inline'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self'; connect-src 'self'; frame-ancestors 'self'; base-uri 'none'; "
    "form-action 'self'"
)
"""The browser itself refuses whatever would leave this server. Dash starts by a script in its page."""


@dataclass(frozen=True, slots=True)
class Listening:
    """Where the dashboard listens, and what it asks of visitors from elsewhere.

    ``threads`` answer at once; ``token`` is None on loopback without a login.
    """

    host: str = "127.0.0.1"
    port: int = 8050
    token: str | None = None
    threads: int = 8


def serve(
    workspace: Workspace, sites: Mapping[str, Site], where: Listening, on_ready: Callable[[str], None]
) -> None:
    """Serve the dashboard until it is interrupted.

    Parameters
    ----------
    on_ready : callable
        Called with the address once the port is bound.

    Raises
    ------
    UsageError
        If it is to listen elsewhere without a token, or the token is too short.
    InputError
        If the port is taken.
    """
    application = guarded(make_app(workspace, sites).server, where)
    # waitress says on its own that it queues; a visitor who reloads is no warning
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)
    try:
        server = waitress.create_server(
            application, host=where.host, port=where.port, threads=where.threads, ident=None, **_LIMITS
        )
    except OSError as fault:
        raise InputError(
            f"port {where.port} of {where.host} cannot be used ({fault.strerror}); another dashboard may be there: "
            "name a free one with --port, or 0 to have one chosen"
        ) from fault
    host = f"[{where.host}]" if ":" in where.host else where.host
    on_ready(f"http://{host}:{server.effective_port}/")
    try:
        server.run()
    finally:
        server.close()


def guarded(server: flask.Flask, where: Listening) -> flask.Flask:
    """Add to a server who may come in and what its pages may load.

    Raises
    ------
    UsageError
        If it listens elsewhere without a token, or the token is too short.
    """
    local = is_loopback(where.host)
    if not local and where.token is None:
        raise UsageError(
            f"a dashboard on {where.host} can be reached by others and needs a token; set TILTWATCH_DASHBOARD_TOKEN or "
            "name a file of mode 600 with --token-file"
        )
    if where.token is not None and len(where.token) < LEAST_TOKEN:
        raise UsageError(f"the token has {len(where.token)} characters; needed are {LEAST_TOKEN} or more")

    @server.before_request
    def check() -> flask.Response | None:
        # a page elsewhere that points its own name at this machine must not read along
        if local and not is_loopback(_host_name(flask.request.host)):
            return flask.Response("this dashboard answers to localhost only\n", 403, mimetype="text/plain")
        return None if where.token is None else _admit(where.token)

    @server.after_request
    def protect(response: flask.Response) -> flask.Response:
        response.headers.setdefault("Content-Security-Policy", _POLICY)
        response.headers["X-Content-Type-Options"] = "nosniff"
        response.headers["Referrer-Policy"] = "same-origin"
        response.headers["Cross-Origin-Resource-Policy"] = "same-origin"
        return response

    return server


_HOST: Final = re.compile(r"(?:\[([0-9a-fA-F:.]+)\]|([0-9A-Za-z.-]+))(?::[0-9]+)?")


def _host_name(host: str) -> str:
    """The name without its port: ``[::1]:8050`` is ``::1``; empty where it is no host."""
    found = _HOST.fullmatch(host)
    return "" if found is None else found.group(1) or found.group(2)


def _admit(token: str) -> flask.Response | None:
    """Let in who brings the token: once in the address (then as a cookie), or as ``Authorization: Bearer``."""
    given = flask.request.args.get("token")
    if given is not None and _same(given, token):
        rest = [(key, value) for key, value in flask.request.args.items(multi=True) if key != "token"]
        # the path alone: two slashes would be another server's name
        path = "/" + flask.request.path.lstrip("/")
        response = flask.Response("", 303, {"Location": path + (f"?{urlencode(rest)}" if rest else "")})
        response.set_cookie(COOKIE, token, httponly=True, samesite="Strict")
        return response
    bearer = flask.request.headers.get("Authorization", "").removeprefix("Bearer ")
    if _same(flask.request.cookies.get(COOKIE, ""), token) or _same(bearer, token):
        return None
    text = "this dashboard needs its token: open /?token=..., or send it as Authorization: Bearer\n"
    return flask.Response(text, 401, {"WWW-Authenticate": "Bearer"}, mimetype="text/plain")


def _same(given: str, token: str) -> bool:
    return hmac.compare_digest(given.encode(), token.encode())
