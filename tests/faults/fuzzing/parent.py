"""The parent: starts children, watches each case, and takes over where one dies."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tests.faults.fuzzing.cases import FAMILIES

MOST_SECONDS = 5.0
"""Of processor time for one case."""

MOST_WALL_S = 60.0
"""For one case, on a machine that has others to serve; a case that sleeps is found by this."""

FIRST_S = 180.0
"""For the start of a child."""

POLL_S = 0.05
TICKS = os.sysconf("SC_CLK_TCK")
ROOT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True, slots=True)
class Part:
    """The cases from ``start`` on, every ``step``-th below ``stop``, of the run of a seed; ``module`` is the child's."""

    start: int
    stop: int
    step: int
    run_seed: int
    module: str = "tests.faults.fuzzing.child"


@dataclass(slots=True)
class _Child:
    """A running child: the case that it is at, since when, and with how much processor time it began."""

    process: "subprocess.Popen[str]"
    number: int | None = None
    since: float = 0.0
    used: float = 0.0
    killed: str = ""


def run_part(part: Part, tell: Callable[[dict[str, object]], None]) -> None:
    """Run the cases of a part; one that kills or holds up its child is told, and the next ones go on."""
    start = part.start
    while start < part.stop:
        child = _start(part, start)
        watcher = threading.Thread(target=_watch, args=(child,), daemon=True)
        watcher.start()
        last = _listen(child, tell)
        code = child.process.wait()
        watcher.join()
        if child.process.stdout is not None:
            child.process.stdout.close()
        if last is None:
            raise RuntimeError(f"a child ended with {code} before its first case; see its messages above")
        if code:
            tell(_lost(child, last, code))
        start = last + part.step


def _start(part: Part, start: int) -> _Child:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(ROOT), "MALLOC_ARENA_MAX": "2"}
    command = [sys.executable, "-m", part.module, *map(str, (start, part.stop, part.step, part.run_seed))]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment, cwd=ROOT)
    return _Child(process, since=time.monotonic())


def _listen(child: _Child, tell: Callable[[dict[str, object]], None]) -> int | None:
    """Take what the child says; the last case that it began."""
    last: int | None = None
    assert child.process.stdout is not None
    for line in child.process.stdout:
        answer = json.loads(line)
        if "begins" in answer:
            last = answer["begins"]
            child.used, child.since, child.number = _processor_s(child.process.pid), time.monotonic(), last
        elif "case" in answer or "again" in answer:
            child.number = None
            tell(answer)
    return last


def _watch(child: _Child) -> None:
    """Kill the child where a case takes too long."""
    while child.process.poll() is None:
        time.sleep(POLL_S)
        number, since, used = child.number, child.since, child.used
        if number is None:
            continue
        wall, spent = time.monotonic() - since, _processor_s(child.process.pid) - used
        if number == child.number and (spent > MOST_SECONDS or wall > MOST_WALL_S):
            child.killed = f"hang: {spent:.1f} s of processor, {wall:.1f} s on the clock"
            child.process.send_signal(signal.SIGKILL)
            return


def _processor_s(pid: int) -> float:
    """Processor time of a process, 0 where it is gone."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / TICKS


def _lost(child: _Child, number: int, code: int) -> dict[str, object]:
    """What is told of a case that its child did not survive."""
    outcome = "hang" if child.killed else "crash"
    return {
        "case": number,
        "family": FAMILIES[number % len(FAMILIES)],
        "seed": "",
        "deeds": [],
        "outcome": outcome,
        "why": child.killed or f"the child ended with code {code}",
        "seconds": time.monotonic() - child.since,
        "cpu": 0.0,
        "peak": 0,
    }
