"""A child process with a time limit that also stops native code: a process group of its own, ended as a whole.

A limit on a thread ends Python between two lines; a loop in C++ goes on behind it (docs/decisions/0014). A process
is ended by the system whatever it does. What such a process was writing is not lost: every file is put in place
whole, and its locks are freed by the system.
"""

import contextlib
import ctypes
import importlib
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Final

from storage.errors import UsageError

GRACE_S: Final = 10.0
"""So long a child may tidy up after it was told to end, before it is killed."""

LOOK_EVERY_S: Final = 0.2
TAIL_BYTES: Final = 4000
PR_SET_PDEATHSIG: Final = 1


@dataclass(frozen=True, slots=True)
class ChildOutcome:
    """How a child ended."""

    exit_code: int
    """As the system gave it; on POSIX the negative number of the signal that ended it."""
    timed_out: bool
    """Whether it was ended at its time limit."""
    seconds: float
    stdout: str
    stderr_tail: str
    """The last 4000 bytes of its messages."""

    @property
    def ok(self) -> bool:
        """Whether it ended by itself and well."""
        return self.exit_code == 0 and not self.timed_out


@dataclass(slots=True)
class Child:
    """A child under way, and the files that its output goes to."""

    process: "subprocess.Popen[bytes]"
    out: IO[bytes]
    err: IO[bytes]
    began_s: float
    timed_out: bool = False

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self.process.poll() is None

    def stop_at_limit(self) -> None:
        """End it with all that it started, because its time is over."""
        self.timed_out = True
        end_group(self.process)

    def outcome(self) -> ChildOutcome:
        """How it ended.

        Raises
        ------
        UsageError
            If it has not ended.
        """
        exit_code = self.process.poll()
        if exit_code is None:
            raise UsageError("the outcome of a child needs a child that ended; stop it first")
        seconds = time.monotonic() - self.began_s
        return ChildOutcome(
            exit_code, self.timed_out, seconds, _text(self.out), _text(self.err)[-TAIL_BYTES:]
        )


def run_in_child(
    args: Sequence[str],
    time_limit_s: float,
    *,
    environment: Mapping[str, str] | None = None,
    folder: Path | None = None,
) -> ChildOutcome:
    """Run a program in a process group of its own, and end the group when its time is over.

    It is told to end (SIGTERM), and killed ten seconds later. Where the caller leaves by an exception
    (an interrupt at the keyboard), the child is ended too.

    Parameters
    ----------
    args
        Program and arguments.
    time_limit_s
        Longest time that it may take, seconds.
    environment
        Its environment; that of the caller where left out.
    folder
        Its working folder; that of the caller where left out.

    Raises
    ------
    UsageError
        If the time limit is not positive.
    OSError
        If the program cannot be started.
    """
    if not time_limit_s > 0:
        raise UsageError(f"a child needs a time limit above 0 s, got {time_limit_s:g} s")
    with started_child(args, environment=environment, folder=folder) as child:
        while child.running:
            if time.monotonic() - child.began_s > time_limit_s:
                child.stop_at_limit()
            with contextlib.suppress(subprocess.TimeoutExpired):
                child.process.wait(LOOK_EVERY_S)
        return child.outcome()


@contextmanager
def started_child(
    args: Sequence[str], *, environment: Mapping[str, str] | None = None, folder: Path | None = None
) -> Iterator[Child]:
    """Start a program in a process group of its own; at the end of the block nothing of it is left.

    Its standard input is a pipe that closes when this process ends (``end_with_parent``).
    """
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(
            list(args),
            stdin=subprocess.PIPE,
            stdout=out,
            stderr=err,
            env=None if environment is None else dict(environment),
            cwd=folder,
            **_own_group(),
        )
        try:
            yield Child(process, out, err, time.monotonic())
        finally:
            end_group(process)
            if process.stdin is not None:
                with contextlib.suppress(OSError):
                    process.stdin.close()


def end_group(process: "subprocess.Popen[bytes]", grace_s: float = GRACE_S) -> None:
    """End a process that leads a group, and all of the group: told first, killed after the grace."""
    if process.poll() is None:
        _signal_group(process, kill=False)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(grace_s)
    # also where it ended by itself: it may have left processes behind
    _signal_group(process, kill=True)
    process.wait()


def end_with_parent() -> None:
    """Called by a child: end when the parent ends, however that ends.

    On Linux the system does it, also while native code runs; elsewhere a thread waits for the end of the standard
    input, which is the parent's pipe.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    threading.Thread(target=_end_at_end_of_input, daemon=True).start()


def how_it_ended(outcome: ChildOutcome, time_limit_s: float) -> str:
    """Say in words how a child ended that did not end well."""
    if outcome.timed_out:
        return f"stopped at its time limit of {time_limit_s:g} s"
    if outcome.exit_code < 0:
        return f"its process was ended by signal {-outcome.exit_code} ({_signal_name(-outcome.exit_code)})"
    last = (outcome.stderr_tail.strip().splitlines() or ["no message"])[-1]
    return f"its process ended with exit code {outcome.exit_code}: {last}"


def _end_at_end_of_input() -> None:
    with contextlib.suppress(OSError, ValueError):
        while os.read(0, 1024):
            pass
    os._exit(1)


def _own_group() -> dict[str, Any]:
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


def _signal_group(process: "subprocess.Popen[bytes]", *, kill: bool) -> None:
    if sys.platform == "win32":
        _end_tree(process.pid)
        return
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL if kill else signal.SIGTERM)


def _end_tree(pid: int) -> None:
    """End a process and its children where there are no process groups to signal."""
    psutil = importlib.import_module("psutil")
    with contextlib.suppress(psutil.NoSuchProcess):
        parent = psutil.Process(pid)
        for process in (*parent.children(recursive=True), parent):
            with contextlib.suppress(psutil.NoSuchProcess):
                process.kill()


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return "unknown"


def _text(file: IO[bytes]) -> str:
    file.seek(0)
    return file.read().decode(errors="replace")
