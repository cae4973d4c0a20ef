"""Memory for points: what the stages of a process take together stays within what the campaign allows.

Every stage says before it begins what it will need at most (``tasks.memory_needs``), and waits until the others leave it so
much, in the order in which they ask. What is needed follows from the number of points alone, so no result depends on the
memory that is there.
"""

import ctypes
import os
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from storage.errors import InputError

PROGRAM_BYTES: Final = 400_000_000
"""What a process takes before it holds a point: the interpreter, the libraries, the compiled loops."""

GIGABYTE: Final = 1_000_000_000

UNLIMITED: Final = 1 << 62

CONTAINER_LIMITS: Final = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")
"""Where Linux says what a container or a service may take."""


@dataclass(frozen=True, slots=True)
class Need:
    """What a stage needs of memory at most, bytes; what it does, and what to do where there is not so much."""

    size: int
    what: str
    way_out: str


class MemoryRoom:
    """Room for the points of one process: ``most_bytes`` in all."""

    def __init__(self, most_bytes: int) -> None:
        self.most_bytes = most_bytes
        self._held = 0
        self._waiting: deque[object] = deque()
        self._changed = threading.Condition()

    def allow(self, most_bytes: int) -> None:
        """Have so much from now on; what is held stays counted."""
        with self._changed:
            self.most_bytes = most_bytes
            self._changed.notify_all()

    @contextmanager
    def held(self, need: Need) -> Iterator[None]:
        """Have room for what a stage needs as long as the block lasts; waits for those who hold it or asked before.

        Raises
        ------
        InputError
            If there is not so much in all; not cached, because another machine or setting has it.
        """
        self._enter(need)
        try:
            yield
        finally:
            with suppress(OSError):
                _give_back()
            with self._changed:
                self._held -= need.size
                self._changed.notify_all()

    def _enter(self, need: Need) -> None:
        ticket = object()
        with self._changed:
            self._waiting.append(ticket)
            try:
                self._changed.wait_for(lambda: self._waiting[0] is ticket and self._fits(need))
                self._held += need.size
            finally:
                self._waiting.remove(ticket)
                self._changed.notify_all()

    def _fits(self, need: Need) -> bool:
        if need.size > self.most_bytes:
            raise _too_little(need, self.most_bytes)
        return self._held + need.size <= self.most_bytes


def bytes_allowed(memory_gb: float | None) -> int:
    """Bytes for points in a process that may take so many gigabytes (10^9 bytes) in all.

    Where none are stated half of the machine's. A machine that does not tell its memory (Windows) sets no bound then.
    """
    if memory_gb is not None:
        return round(memory_gb * GIGABYTE) - PROGRAM_BYTES
    whole = machine_bytes()
    return UNLIMITED if whole is None else max(whole // 2 - PROGRAM_BYTES, PROGRAM_BYTES)


def machine_bytes() -> int | None:
    """Memory of this machine, or what this container may take of it, bytes; None where the system does not tell."""
    try:
        known = [os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")]
    except (AttributeError, ValueError, OSError):
        return None
    for name in CONTAINER_LIMITS:
        # "max" where there is no limit
        with suppress(OSError, ValueError):
            known.append(int(Path(name).read_text(encoding="ascii")))
    return min(known)


_ROOM: Final = MemoryRoom(bytes_allowed(None))


def allow_memory(memory_gb: float | None) -> None:
    """Let the stages of this process take so much from now on: ``[execution] memory_gb`` of the campaign that it runs."""
    _ROOM.allow(bytes_allowed(memory_gb))


def room_for(need: Need) -> AbstractContextManager[None]:
    """Have room in this process for what a stage needs: see ``MemoryRoom.held``."""
    return _ROOM.held(need)


def _give_back() -> None:
    """Let the system have what arrays of the stage left in the allocator; else the process stays as large as it was."""
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Callable[[int], int] | None:
    """The function of glibc for that; None on other systems, which do it by themselves or not at all."""
    try:
        found: Callable[[int], int] = ctypes.CDLL(None).malloc_trim
    except (OSError, TypeError, AttributeError):
        return None
    return found


def _too_little(need: Need, most_bytes: int) -> InputError:
    least_gb = (need.size + PROGRAM_BYTES) / GIGABYTE
    allowed_gb = (most_bytes + PROGRAM_BYTES) / GIGABYTE
    fault = InputError(
        f"{need.what} needs up to {least_gb:.2f} GB of memory, {allowed_gb:.2f} GB are allowed: set [execution] memory_gb "
        f"to {least_gb:.2f} or more on a machine that has it{need.way_out}"
    )
    fault.__cause__ = MemoryError()
    return fault
