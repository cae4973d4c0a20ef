"""A child process ends at its time limit whatever it does, and leaves nothing behind."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from flows.child_process import how_it_ended, run_in_child
from storage.errors import UsageError
from tests.flows.calls import ROOT

NATIVE = "import ctypes; ctypes.CDLL(None).sleep(600)"
"""Sleeps in C, where Python can interrupt nothing."""
DEAF = "import ctypes, signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); ctypes.CDLL(None).sleep(600)"


def python(code: str) -> list[str]:
    return [sys.executable, "-c", code]


def gone(pid: int) -> bool:
    """Whether a process is gone, or only waits for its parent to notice."""
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        time.sleep(0.05)
    return False


def test_a_child_that_ends_by_itself_gives_its_output_and_exit_code() -> None:
    outcome = run_in_child(python("import sys; print('found'); sys.exit('no such scan')"), 60.0)
    assert (outcome.exit_code, outcome.stdout, outcome.timed_out, outcome.ok) == (1, "found\n", False, False)
    assert how_it_ended(outcome, 60.0) == "its process ended with exit code 1: no such scan"


def test_native_code_is_stopped_at_the_time_limit() -> None:
    outcome = run_in_child(python(NATIVE), 0.5)
    assert outcome.timed_out
    assert outcome.exit_code == -signal.SIGTERM
    assert how_it_ended(outcome, 0.5) == "stopped at its time limit of 0.5 s"


def test_what_a_child_started_ends_with_it(tmp_path: Path) -> None:
    note = tmp_path / "pid"
    code = f"import subprocess, sys; p = subprocess.Popen([sys.executable, '-c', {DEAF!r}]); "
    code += f"open({str(note)!r}, 'w').write(str(p.pid)); p.wait()"
    assert run_in_child(python(code), 2.0).timed_out
    assert gone(int(note.read_text()))


def test_a_child_that_crashes_is_told_by_its_signal() -> None:
    outcome = run_in_child(python("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"), 60.0)
    assert how_it_ended(outcome, 60.0) == "its process was ended by signal 11 (SIGSEGV)"


def test_a_child_tied_to_its_parent_ends_when_that_is_killed(tmp_path: Path) -> None:
    note = tmp_path / "pid"
    child = "from flows.child_process import end_with_parent; import os; end_with_parent(); "
    child += f"open({str(note)!r} + '.part', 'w').write(str(os.getpid())); "
    child += f"os.replace({str(note)!r} + '.part', {str(note)!r}); {NATIVE}"
    parent = "from flows.child_process import run_in_child; import sys; "
    parent += f"run_in_child([sys.executable, '-c', {child!r}], 600)"
    process = subprocess.Popen(python(parent), env={**os.environ, "PYTHONPATH": str(ROOT)})
    try:
        deadline = time.monotonic() + 60.0
        while not note.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        pid = int(note.read_text())
    finally:
        process.kill()
        process.wait(20)
    assert gone(pid)


def test_a_time_limit_is_above_zero() -> None:
    with pytest.raises(UsageError, match="needs a time limit above 0 s, got 0 s"):
        run_in_child(python("pass"), 0.0)
