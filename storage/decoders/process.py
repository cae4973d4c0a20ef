"""A decoder in a child process: asked, answered, and ended where it crashes, loops or wants too much."""

import json
import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from storage.decoders import child
from storage.decoders.shared_memory import SharedMemory

GRACE_S: Final = 5.0
"""After its limit of waiting a child that did not end itself is killed; on Windows that is what ends it."""

START_S: Final = 60.0
"""For a child to start and answer, also on a machine that is busy."""

PASSED_ON: Final = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "SYSTEMROOT", "TEMP", "TMP", "RAYON_NUM_THREADS")
"""Of the environment; secrets are nothing for a process that may be taken over by the bytes of a scan."""

MOST_THREADS: Final = 16
"""Of a child, where the user names no other number: each has a stack, which counts as memory."""

ENVIRONMENT: Final = {"ARROW_DEFAULT_MEMORY_POOL": "system", "MALLOC_ARENA_MAX": "2", "OMP_NUM_THREADS": "1"}
"""Memory is taken as it is used: the limit counts what is taken."""


class DecoderFault(Exception):  # noqa: N818 - never leaves the readers
    """What a decoder did with its input, as the end of a sentence: it refused, crashed, or wanted too much."""


class DecoderRefusal(DecoderFault):
    """The decoder itself refused its input, in good order: it may go on with the next."""


class DecoderLost(OSError):  # noqa: N818 - as above
    """A decoder is gone for a reason that need not lie in its input: with less to do for the machine it may work."""


@dataclass(frozen=True, slots=True)
class DecoderProgram:
    """What a child runs: a file with ``HANDLERS`` by name, which imports nothing of ours; and the memory it may take."""

    name: str
    file: Path
    memory_bytes: int


@dataclass(frozen=True, slots=True)
class Limits:
    """Of one request: seconds of processor time, and seconds until it is answered."""

    computing_s: float
    waiting_s: float


HELLO: Final = Limits(10.0, START_S)


class DecoderProcess:
    """One child. It is used by one thread at a time.

    Raises
    ------
    DecoderLost
        If it cannot be started.
    """

    def __init__(self, program: DecoderProgram) -> None:
        self.program = program
        self.memory = SharedMemory()
        self._limits = HELLO
        self._expired = False
        try:
            self._process = self._started()
        except OSError as fault:
            self.memory.close()
            raise DecoderLost(f"no decoder, because no process can be started ({fault.strerror})") from fault
        self._questions, self._answers = (
            cast(IO[bytes], self._process.stdin),
            cast(IO[bytes], self._process.stdout),
        )
        try:
            self.ask("hello", HELLO)
        except DecoderFault as fault:
            self.end()
            raise DecoderLost(f"no decoder, because its process does not start: {fault}") from fault
        except BaseException:
            self.end()
            raise

    @property
    def pid(self) -> int:
        """Number of the child."""
        return self._process.pid

    def ask(self, do: str, limits: Limits, **given: Any) -> Any:
        """Have a request answered: ``send`` and ``answer``."""
        self.send(do, limits, **given)
        return self.answer()

    def send(self, do: str, limits: Limits, **given: Any) -> None:
        """Send a request, to be answered while this process does something else; one at a time.

        Raises
        ------
        DecoderFault, DecoderLost
            If the child is gone.
        """
        self._limits = limits
        request = {
            "do": do,
            "given": given,
            "computing_s": limits.computing_s,
            "waiting_s": limits.waiting_s,
            "memory_bytes": self.memory.n_bytes,
        }
        try:
            self._questions.write(json.dumps(request).encode() + b"\n")
        except BrokenPipeError as fault:
            raise self._how_it_ended() from fault

    def answer(self) -> Any:
        """Answer of the last request.

        Raises
        ------
        DecoderFault
            If the decoder refuses, crashes, or goes beyond a limit of its input's own making.
        DecoderLost
            If the system or this process ended it.
        OSError
            If the system refuses it the file.
        """
        watchdog = threading.Timer(self._limits.waiting_s + GRACE_S, self._expire)
        watchdog.daemon = True
        watchdog.start()
        try:
            line = self._answers.readline()
        finally:
            watchdog.cancel()
        if not line.endswith(b"\n"):
            raise self._how_it_ended()
        answer = json.loads(line)
        if "fault" in answer:
            raise self._told(answer["fault"], answer["errno"], answer["text"])
        return answer["value"]

    def see(self, start: int, n_bytes: int) -> NDArray[np.uint8]:
        """See what the child wrote (n_bytes,); the next request may write over it."""
        return self.memory.bytes(start, n_bytes)

    @property
    def runs(self) -> bool:
        """Whether the child is there."""
        return self._process.poll() is None

    def end(self) -> None:
        """End the child, whatever it does."""
        self._process.kill()
        self._process.wait()
        self._close()

    def forget(self) -> None:
        """Leave the child to the process that this one was forked from."""
        self._process.returncode = 0
        self._close()

    def _started(self) -> "subprocess.Popen[bytes]":
        start = {
            "program": str(self.program.file),
            "memory": self.memory.handle,
            "memory_bytes": self.program.memory_bytes,
            "import_from": [os.path.abspath(place) for place in sys.path if place],  # noqa: PTH100 - not resolved
        }
        # without site, environment and the folder of the file: it starts in hundredths of a second
        words = [sys.executable, "-I", "-S", "-B", child.__file__, json.dumps(start)]
        threads = {"RAYON_NUM_THREADS": str(min(os.cpu_count() or 1, MOST_THREADS))}
        given = {name: os.environ[name] for name in PASSED_ON if name in os.environ}
        environment = threads | given | ENVIRONMENT
        return subprocess.Popen(
            words,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            bufsize=0,
            pass_fds=self.memory.inherited,
        )

    def _expire(self) -> None:
        self._expired = True
        self._process.kill()

    def _told(self, kind: str, number: int | None, text: str) -> Exception:
        if number is not None:
            return OSError(number, text)
        if kind == "MemoryError":
            return DecoderFault(f"a decoder that wants {self._too_much}")
        if "ThreadPoolBuildError" in text:
            return DecoderLost(f"a decoder that cannot start its threads ({text})")
        # a panic is no answer that its authors thought of
        return (DecoderFault if kind == "PanicException" else DecoderRefusal)(f"{kind} ({text})")

    @property
    def _too_much(self) -> str:
        return f"more than {self.program.memory_bytes >> 20} MiB"

    def _how_it_ended(self) -> Exception:
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(GRACE_S)
        code = self._process.poll()
        name = "no end" if code is None else f"exit code {code}" if code >= 0 else _signal_name(-code)
        if self._expired or name == "SIGALRM":
            return DecoderLost(f"no answer of its decoder in {self._limits.waiting_s:g} s")
        if name == "SIGPROF":
            return DecoderFault(f"a decoder that computes for over {self._limits.computing_s:g} s")
        if name in ("SIGKILL", "SIGTERM", "no end"):
            return DecoderLost(f"a decoder that was ended from outside ({name})")
        return DecoderFault(f"a decoder that crashes or wants {self._too_much} ({name})")

    def _close(self) -> None:
        self._questions.close()
        self._answers.close()
        self.memory.close()


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
