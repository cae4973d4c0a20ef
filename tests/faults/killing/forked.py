"""Runs that are forked off a process which has imported what they need: that takes seconds, and writes nothing.

``python -m tests.faults.killing.forked FOLDER NAME`` (of the workspace) reads what to run, a line each; it tells the number
of its process, and its exit code.
"""

import importlib
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Final

from storage.workspace import Workspace
from tests.faults.killing.launched import launch
from tests.flows.calls import ROOT

DIED: Final = -1000
"""Told instead of a number where the process that forks is gone."""


class ForkedRun:
    """A run as ``subprocess.Popen`` shows one; it is a child of the process that forks."""

    def __init__(self, told: "SimpleQueue[int]") -> None:
        """Take the first number that is told as its process; the second will be its exit code."""
        self._told = told
        self.pid = told.get()
        if self.pid == DIED:
            raise AssertionError("the process that forks is gone")
        self.returncode: int | None = None

    def poll(self) -> int | None:
        """Its exit code; None while it runs."""
        if self.returncode is None:
            try:
                self.returncode = self._told.get_nowait()
            except Empty:
                return None
        return self.returncode

    def wait(self) -> int:
        """Wait for its end; gives its exit code."""
        if self.returncode is None:
            self.returncode = self._told.get()
        return self.returncode


class Forker:
    """The process that runs are forked off; one at a time."""

    def __init__(self, workspace: Path, environment: Mapping[str, str]) -> None:
        """Start it; a run of another workspace cannot be forked off it."""
        self._told: SimpleQueue[int] = SimpleQueue()
        workspace.parent.mkdir(parents=True, exist_ok=True)
        self._process = subprocess.Popen(
            # whatever names the workspace is taken for something that works on it
            [sys.executable, "-m", "tests.faults.killing.forked", str(workspace.parent), workspace.name],
            cwd=ROOT,
            env=dict(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        threading.Thread(target=self._listen, daemon=True).start()
        milliseconds = self._told.get()
        if milliseconds == DIED:
            raise AssertionError("the process that forks could not import what a run needs")
        self.start_cpu_s = milliseconds / 1000.0
        """Processor time of what a run of its own process does first, seconds."""

    def _listen(self) -> None:
        for line in self._process.stdout or ():
            self._told.put(int(line))
        # nobody waits for ever for one that died
        for _ in range(2):
            self._told.put(DIED)

    def start(
        self, words: Sequence[str], kill_at: int, files: Sequence[Path], environment: Mapping[str, str]
    ) -> ForkedRun:
        """Begin a run; ``files`` are those of its steps and of its messages."""
        asked = [list(words), kill_at, [str(file) for file in files], dict(environment)]
        if self._process.stdin is None:
            raise AssertionError("it was started with a pipe")
        self._process.stdin.write(f"{json.dumps(asked)}\n")
        self._process.stdin.flush()
        return ForkedRun(self._told)

    def end(self) -> None:
        """End it; runs that were forked off it go on."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait()


def serve(workspace: Path) -> int:
    """Fork runs off until nobody asks for one; the forked process returns here, too, with its exit code."""
    _import_all(workspace)
    # those of native libraries (memory, tables, BLAS) are renewed by them in a forked process
    if threading.active_count() > 1:
        raise AssertionError("a process with threads cannot be forked: some import started one")
    _tell(int(1000 * time.process_time()))
    for line in sys.stdin:
        words, kill_at, files, environment = json.loads(line)
        child = os.fork()
        if child == 0:
            _be_apart(Path(files[1]), environment)
            return launch(workspace, kill_at, Path(files[0]), words)
        _tell(child)
        _tell(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    return 0


def _import_all(workspace: Path) -> None:
    from flows.prefect_home import take_home  # noqa: PLC0415 (Prefect reads its settings when it is imported)

    take_home(Workspace(workspace))
    import flows.cli  # noqa: PLC0415
    import flows.commands.run  # noqa: PLC0415
    import flows.mending  # noqa: PLC0415
    import flows.monitor_campaign  # noqa: PLC0415
    import flows.progress  # noqa: PLC0415
    import flows.recorded_run  # noqa: PLC0415
    import flows.run_campaign  # noqa: PLC0415
    import flows.run_report  # noqa: PLC0415, F401
    from flows.early_imports import MODULES, find_versions  # noqa: PLC0415

    for name in MODULES:
        importlib.import_module(name)
    from tasks.geometry.compiled_forms import load_forms  # noqa: PLC0415

    load_forms()
    find_versions()


def _be_apart(messages: Path, environment: Mapping[str, str]) -> None:
    """What ``subprocess.Popen`` does for a process of its own."""
    os.setsid()
    nothing = os.open(os.devnull, os.O_RDWR)
    heard = os.open(messages, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for handle, stands_for in ((nothing, 0), (nothing, 1), (heard, 2)):
        os.dup2(handle, stands_for)
    # what was set before the imports is what the run would set itself
    os.environ.update(environment)


def _tell(number: int) -> None:
    sys.stdout.write(f"{number}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(serve(Path(sys.argv[1]) / sys.argv[2]))
