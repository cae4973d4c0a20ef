"""What a watch tells: lines for people, JSON lines for programs, and the same JSON lines in a log of the workspace."""

import json
import re
import sys
import threading
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Final

from flows.faults import keep_log
from flows.terminal import complain, say
from storage.errors import StorageError
from storage.intake import append_watch_log
from storage.workspace import Workspace

CONTROL: Final = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""Control characters but for the tab and the end of a line, and what turns the direction of writing around."""

Facts = Mapping[str, object]
Now = Callable[[], datetime]

TROUBLES: Final = frozenset({"kept", "error"})
"""Events that a user has to do something about."""


def utc_now() -> datetime:
    """The time."""
    return datetime.now(UTC)


@dataclass(frozen=True, slots=True)
class WatchEvent:
    """Something that happened: its kind, the facts for programs, and the lines for people."""

    kind: str
    lines: tuple[str, ...]
    facts: Facts = field(default_factory=dict)


def _harmless(line: str) -> str:
    """The line without what a terminal would obey: a name in the inbox may hold anything but a slash."""
    return CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode(), line)


def fault_in_words(fault: BaseException) -> str:
    """Say that the program has a fault, and where its traceback is."""
    log = keep_log("".join(traceback.format_exception(fault)))
    return f"this is a fault of tiltwatch: {type(fault).__name__}: {fault}; traceback in {log}"


class Teller:
    """Tells events, from any thread; an event about the same thing that says the same is told once."""

    def __init__(self, ws: Workspace, structure: str, *, as_json: bool, now: Now = utc_now) -> None:
        self._ws = ws
        self._structure = structure
        self._as_json = as_json
        self._now = now
        self._told: dict[str, tuple[str, ...]] = {}
        self._speaking = threading.Lock()
        self.troubled = False
        """Whether anything was told that a user has to do something about."""

    def tell(self, event: WatchEvent) -> None:
        """Write an event to the screen and to the log."""
        self.troubled = self.troubled or event.kind in TROUBLES
        content = {"event": event.kind, "time": self._now().isoformat(timespec="seconds"), **event.facts}
        line = json.dumps({**content, "text": list(event.lines)}, default=str)
        with self._speaking:
            if self._as_json:
                say(line)
            elif event.kind in TROUBLES:
                complain(*map(_harmless, event.lines))
            else:
                say(*map(_harmless, event.lines))
            sys.stdout.flush()
            try:
                append_watch_log(self._ws, self._structure, line)
            except StorageError as fault:
                # a full disk must not stop the watch: the screen has the event
                complain(f"error: {fault}")

    def tell_once(self, about: str, event: WatchEvent) -> None:
        """Tell an event unless the last one about this said the same."""
        if self._told.get(about) != event.lines:
            self._told[about] = event.lines
            self.tell(event)

    def forget(self, about: str) -> None:
        """Let the next event about this be told whatever it says."""
        self._told.pop(about, None)
