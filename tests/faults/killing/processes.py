"""Start a run, kill it with all that it started at a moment, and see what is still alive."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import psutil

from tests.faults.killing.forked import ForkedRun, Forker
from tests.flows.calls import ROOT

LIMIT_S: Final = 1200.0
"""No run takes so long, however loaded the machine is."""

LOOK_EVERY_S: Final = 0.005

TICKS: Final = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True, slots=True)
class Moment:
    """When a run is killed: at so many seconds of its own processor time and a wait, or before a step; after its end."""

    cpu_s: float | None = None
    wait_s: float = 0.0
    step: int = 0


@dataclass(frozen=True, slots=True)
class Ended:
    """How a run ended."""

    exit_code: int
    """As the system gave it: -9 where it was killed."""
    cpu_s: float
    wall_s: float
    steps: int
    """Changes of names in the workspace; 0 where it was killed."""
    messages: str


def run_to_its_end_or(
    moment: Moment,
    command: Sequence[str],
    workspace: Path,
    keep_server_s: float,
    forker: Forker | None = None,
) -> Ended:
    """Run until it ends, or until the moment; then all of it is dead, but not a server.

    Without a ``forker`` it is a process of its own from the start.
    """
    told, messages = workspace.with_name("steps.txt"), workspace.with_name("messages.txt")
    told.unlink(missing_ok=True)
    began_s = time.monotonic()
    environment = environment_of_runs(keep_server_s)
    process: subprocess.Popen[bytes] | ForkedRun
    if forker is None:
        process = _launched(workspace, moment.step, (told, messages), command, environment)
    else:
        process = forker.start(command, moment.step, (told, messages), environment)
    cpu_s = _wait(process, moment, began_s)
    if process.poll() is None:
        _kill_tree(process.pid)
    exit_code = process.wait()
    steps = len(told.read_text("utf-8").splitlines()) if told.exists() else 0
    text = messages.read_text("utf-8", errors="replace") if messages.exists() else ""
    return Ended(exit_code, cpu_s, time.monotonic() - began_s, steps, text)


def _launched(
    workspace: Path,
    kill_at: int,
    files: tuple[Path, Path],
    command: Sequence[str],
    environment: Mapping[str, str],
) -> "subprocess.Popen[bytes]":
    told, messages = files
    words = [sys.executable, "-m", "tests.faults.killing.launched", str(workspace), str(kill_at), str(told)]
    with messages.open("wb") as heard:
        return subprocess.Popen(
            [*words, *command],
            cwd=ROOT,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=heard,
            start_new_session=True,
        )


def environment_of_runs(keep_server_s: float) -> Mapping[str, str]:
    """Nothing of Prefect's from outside; native code in one thread."""
    ours = {name: value for name, value in os.environ.items() if not name.startswith("PREFECT_")}
    ours |= {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "TILTWATCH_KEEP_SERVER_S": str(keep_server_s)}
    return {name: value for name, value in ours.items() if name != "TILTWATCH_SERVER"}


def _wait(process: "subprocess.Popen[bytes] | ForkedRun", moment: Moment, began_s: float) -> float:
    """Wait for the end or the moment; gives the processor time of the run by then, seconds."""
    cpu_s = 0.0
    while process.poll() is None:
        if time.monotonic() - began_s > LIMIT_S:
            _kill_tree(process.pid)
            raise TimeoutError(f"a run took more than {LIMIT_S:.0f} s")
        cpu_s = _cpu_s(process.pid) or cpu_s
        if moment.cpu_s is not None and cpu_s >= moment.cpu_s:
            break
        time.sleep(LOOK_EVERY_S)
    time.sleep(moment.wait_s)
    return cpu_s


def _cpu_s(pid: int) -> float:
    try:
        told = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(told[11]) + int(told[12])) / TICKS


def _kill_tree(pid: int) -> None:
    """Kill a process and its children, but not the server, which left the group of the run; it may just have ended."""
    with suppress(ProcessLookupError, psutil.NoSuchProcess):
        group = os.getpgid(pid)
        os.kill(pid, signal.SIGSTOP)  # else it starts others meanwhile
        for child in psutil.Process(pid).children(recursive=True):
            with suppress(ProcessLookupError, psutil.NoSuchProcess):
                if os.getpgid(child.pid) == group:
                    child.kill()
        os.kill(pid, signal.SIGKILL)


def processes_of(workspace: Path) -> list[psutil.Process]:
    """All living processes that name the workspace on their command line: runs, their children and servers."""
    found = []
    for process in psutil.process_iter(["cmdline", "status"]):
        words = " ".join(process.info["cmdline"] or ())
        # a folder beside it may begin with the same letters
        named = f"{workspace}/" in words or f"{workspace} " in f"{words} "
        if named and process.pid != os.getpid() and process.info["status"] != psutil.STATUS_ZOMBIE:
            found.append(process)
    return found


def kill_processes_of(workspace: Path) -> int:
    """Kill whatever works on a workspace; gives how many were alive."""
    alive = processes_of(workspace)
    for process in alive:
        process.kill()
    psutil.wait_procs(alive, timeout=30.0)
    return len(alive)


def outlive(workspace: Path, patience_s: float) -> list[str]:
    """Processes of a workspace that are still there when the patience is over."""
    deadline = time.monotonic() + patience_s
    while (alive := processes_of(workspace)) and time.monotonic() < deadline:
        time.sleep(0.1)
    return [f"process {one.pid} is alive: {' '.join(one.info['cmdline'] or ())[:120]}" for one in alive]
