"""What stands before the upload protocol: the token, what is not offered, and a new request that takes over a dead one.

It is here, and not a dependency of the router, because tuspyserver 4.4.3 writes the bytes of a PATCH before it asks its
``auth`` dependency.
"""

import asyncio
import hmac
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Final

from flows.upload.store import UID

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

PREFIX: Final = "/files"
IDLE_S: Final = 120.0
"""A sender from whom nothing came for so long is gone; what it sent is kept."""

TAKE_OVER_S: Final = 15.0
EXTENSIONS: Final = "creation,expiration,termination"
"""What tuspyserver offers beyond these is refused: it takes whole bodies into memory, or joins parts that we would take
for scans."""


@dataclass(eq=False, slots=True)
class _Turn:
    """A request about an upload; ``give_way`` is set when a later one comes, ``over`` when it has ended."""

    give_way: asyncio.Event = field(default_factory=asyncio.Event)
    over: asyncio.Event = field(default_factory=asyncio.Event)


class Gate:
    """An ASGI application before another."""

    def __init__(self, app: App, token: str, max_bytes: int) -> None:
        self._app = app
        self._wanted = f"Bearer {token}".encode()
        self._max_bytes = max_bytes
        self._turns: dict[str, list[_Turn]] = {}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, or answer it."""
        if scope["type"] != "http":
            return
        headers = _headers(scope)
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            await _answer(send, *refusal)
        elif scope["method"] == "OPTIONS":
            await _answer(send, 204, "", self._offers())
        else:
            await self._in_turn(scope, receive, send)

    def _refusal(self, scope: Scope, headers: dict[bytes, bytes]) -> tuple[int, str] | None:
        if not hmac.compare_digest(headers.get(b"authorization", b""), self._wanted):
            return 401, "needs Authorization: Bearer TOKEN"
        if b"upload-concat" in headers or b"upload-defer-length" in headers:
            return 400, f"not offered; offered are {EXTENSIONS}"
        is_creation = scope["method"] == "POST" and b"x-http-method-override" not in headers
        if is_creation and (headers.get(b"content-length", b"0") != b"0" or b"transfer-encoding" in headers):
            return 400, "an upload is created without content; send it with PATCH"
        return None

    def _offers(self) -> Iterable[tuple[bytes, bytes]]:
        return (
            (b"tus-resumable", b"1.0.0"),
            (b"tus-version", b"1.0.0"),
            (b"tus-extension", EXTENSIONS.encode()),
            (b"tus-max-size", str(self._max_bytes).encode()),
        )

    async def _in_turn(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request an upload at a time; a new one ends the one before, whose sender has lost the connection."""
        uid = scope["path"].rstrip("/").rpartition("/")[2]
        if not UID.fullmatch(uid):
            await self._app(scope, receive, send)
            return
        turns, turn = self._turns.setdefault(uid, []), _Turn()
        earlier = list(turns)
        turns.append(turn)
        try:
            for other in earlier:
                other.give_way.set()
                with suppress(TimeoutError):
                    await asyncio.wait_for(other.over.wait(), TAKE_OVER_S)
            await self._app(scope, _interruptible(receive, turn.give_way), send)
        finally:
            turn.over.set()
            turns.remove(turn)
            if not turns:
                self._turns.pop(uid, None)


def _interruptible(receive: Receive, give_way: asyncio.Event) -> Receive:
    """The bytes of a request until it ends, gives way, or nothing came for too long."""

    async def receive_or_end() -> Message:
        coming = asyncio.ensure_future(receive())
        ending = asyncio.ensure_future(give_way.wait())
        try:
            await asyncio.wait({coming, ending}, timeout=IDLE_S, return_when=asyncio.FIRST_COMPLETED)
            return coming.result() if coming.done() else {"type": "http.disconnect"}
        finally:
            coming.cancel()
            ending.cancel()

    return receive_or_end


def _headers(scope: Scope) -> dict[bytes, bytes]:
    return {name.lower(): value for name, value in scope["headers"]}


async def _answer(send: Send, status: int, text: str, headers: Iterable[tuple[bytes, bytes]] = ()) -> None:
    body = text.encode()
    more = ((b"www-authenticate", b"Bearer"),) if status == 401 else ()
    head = [(b"content-length", str(len(body)).encode()), (b"content-type", b"text/plain"), *headers, *more]
    await send({"type": "http.response.start", "status": status, "headers": head})
    await send({"type": "http.response.body", "body": body})
