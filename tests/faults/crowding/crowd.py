"""What every member of the crowd does: calls of the real command line, one after the other, until time is up."""

import json
import os
import random
import re
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from tests.faults.crowding.site import Site
from tests.flows.calls import ROOT

CALL_S: Final = 300.0
"""A call that takes longer hangs."""

WRONG_WORDS: Final = re.compile(
    r"Traceback|in use|is locked|lock file|another process|No such file|fault of the program|disk I/O error|Errno",
    re.IGNORECASE,
)
"""What must never be told."""

STATES: Final = frozenset({0, 4, 5, 6})
"""Exit codes that tell of the structure, not of the call."""


@dataclass(frozen=True)
class Call:
    """A call that ended."""

    words: Sequence[str]
    code: int
    out: str
    err: str
    seconds: float

    @property
    def answer(self) -> Mapping[str, Any]:
        """The one JSON object on stdout."""
        content = json.loads(self.out.splitlines()[-1])
        assert isinstance(content, dict)
        return content


@dataclass
class Crowd:
    """The site, the end of the time, and what was told."""

    site: Site
    end: threading.Event = field(default_factory=threading.Event)
    findings: list[str] = field(default_factory=list)
    calls: Counter[str] = field(default_factory=Counter)
    seconds: dict[str, float] = field(default_factory=dict)
    runs: list[str] = field(default_factory=list)
    """Runs that were reported done."""
    deeds: list[tuple[str, str, str]] = field(default_factory=list)
    """Alarm, action and note of every deed that was reported done."""

    def call(self, *words: object, codes: frozenset[int] = frozenset({0})) -> Call:
        """Call the command line as a user does, and note what is wrong with its answer."""
        asked = [str(word) for word in words]
        command = [*command_line(), *asked, "--workspace", str(self.site.workspace)]
        began = time.monotonic()
        done = subprocess.run(
            command,
            cwd=ROOT,
            env=environment(),
            capture_output=True,
            encoding="utf-8",
            timeout=CALL_S,
            check=False,
        )
        call = Call(asked, done.returncode, done.stdout, done.stderr, time.monotonic() - began)
        self.calls[asked[0]] += 1
        self.seconds[asked[0]] = max(call.seconds, self.seconds.get(asked[0], 0.0))
        if call.code not in codes:
            self.find(f"{' '.join(asked)}: exit code {call.code}: {call.err[-1500:]}{call.out[-1500:]}")
        if found := WRONG_WORDS.search(call.err + call.out):
            self.find(f"{' '.join(asked)}: told {found[0]!r}: {call.err[-1500:]}")
        return call

    def find(self, what: str) -> None:
        """Put a finding down, and tell it at once."""
        self.findings.append(what)
        sys.stderr.write(f"FINDING {time.strftime('%H:%M:%S')} {what}\n")


Member = Callable[[Crowd, random.Random], None]


def command_line() -> list[str]:
    """The program, as it is called."""
    return [sys.executable, "-m", "flows.cli"]


def environment() -> dict[str, str]:
    """That of every call: a workflow server is kept for a while, as for users, and then ends."""
    return {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "TILTWATCH_KEEP_SERVER_S": "15",
        "PYTHONIOENCODING": "utf-8",
    }


def keep_doing(crowd: Crowd, member: Member, rng: random.Random) -> None:
    """Let a member do what it does again and again until the end."""
    while not crowd.end.is_set():
        try:
            member(crowd, rng)
        except Exception as fault:  # the harness itself, or an answer that is none
            crowd.find(f"{member.__name__}: {type(fault).__name__}: {fault}")
            time.sleep(1.0)
