"""Visitors without a window: each asks for what a browser asks for, page after page."""

import json
import threading
import time
import urllib.request
from collections.abc import Sequence
from dataclasses import dataclass, field

FRAME = ("/", "/_dash-layout", "/_dash-dependencies")


@dataclass
class Visitor(threading.Thread):
    """One visitor: opens the frame, then turns pages until the time is over; notes seconds and what went wrong."""

    url: str
    paths: Sequence[str]
    seconds: float
    daemon: bool = True
    took_s: list[float] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        threading.Thread.__init__(self, daemon=True)

    def __hash__(self) -> int:
        return id(self)

    def run(self) -> None:
        """Visit until the time is over."""
        end = time.monotonic() + self.seconds
        for path in FRAME:
            self._ask(path)
        while time.monotonic() < end:
            for path in self.paths:
                began = time.monotonic()
                self._ask("/_dash-update-component", page_request(path))
                self.took_s.append(time.monotonic() - began)
                if time.monotonic() > end:
                    break

    def _ask(self, path: str, body: dict[str, object] | None = None) -> None:
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(  # noqa: S310 (loopback)
            self.url.rstrip("/") + path, data=data, headers={"Content-Type": "application/json"}
        )
        try:
            with urllib.request.urlopen(request, timeout=30.0) as answer:  # noqa: S310
                text = answer.read().decode()
        except OSError as fault:
            self.wrong.append(f"{path}: {fault}")
            return
        if "This page failed" in text or "This cannot be shown" in text:
            self.wrong.append(f"{path} {body}: {text[:500]}")


def page_request(path: str) -> dict[str, object]:
    """What the frame sends to have a page filled."""
    pathname, _, search = path.partition("?")
    return {
        "output": "..app.children...stamp.data..",
        "outputs": [{"id": "app", "property": "children"}, {"id": "stamp", "property": "data"}],
        "inputs": [
            {"id": "url", "property": "pathname", "value": pathname},
            {"id": "url", "property": "search", "value": f"?{search}" if search else ""},
            {"id": "newer", "property": "data", "value": None},
        ],
        "changedPropIds": ["url.pathname"],
    }
