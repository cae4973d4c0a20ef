"""Memory that a process shares with a child of its own, without a name that could be left behind."""

import mmap
import os
import sys
import tempfile
from contextlib import suppress
from typing import IO, Final
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

NAME: Final = "tiltwatch-decoder"


class SharedMemory:
    """Memory that grows to what is asked for; it is gone when both processes are, however they end."""

    def __init__(self) -> None:
        self._file = _file_without_name()
        self._mapped: mmap.mmap | None = None
        self._tag = f"{NAME}-{uuid4().hex}"

    @property
    def handle(self) -> int | str:
        """What the child knows it by: on POSIX an open file that it inherits."""
        return self._tag if self._file is None else self._file.fileno()

    @property
    def inherited(self) -> tuple[int, ...]:
        """Open files that the child needs."""
        return () if self._file is None else (self._file.fileno(),)

    @property
    def n_bytes(self) -> int:
        """How much there is."""
        return 0 if self._mapped is None else len(self._mapped)

    def grow(self, n_bytes: int) -> None:
        """Make it at least so large; what was in it is lost."""
        if n_bytes <= self.n_bytes:
            return
        if sys.platform == "win32":
            self._mapped = mmap.mmap(-1, n_bytes, tagname=f"{self._tag}-{n_bytes}")
            return
        if self._file is None:
            raise ValueError("memory that is closed cannot grow")
        os.ftruncate(self._file.fileno(), n_bytes)
        self._mapped = mmap.mmap(self._file.fileno(), n_bytes)
        # larger pages where the system has them for shared memory
        if hasattr(mmap, "MADV_HUGEPAGE"):
            with suppress(OSError):
                self._mapped.madvise(mmap.MADV_HUGEPAGE)

    def bytes(self, start: int, n_bytes: int) -> NDArray[np.uint8]:
        """See some of it (n_bytes,), as it is at any time."""
        if self._mapped is None:
            raise IndexError("nothing was shared yet")
        return np.frombuffer(self._mapped, np.uint8, n_bytes, start)

    def close(self) -> None:
        """Let go of it; what somebody still sees stays until they do not."""
        self._mapped = None
        if self._file is not None:
            self._file.close()


def _file_without_name() -> IO[bytes] | None:
    if sys.platform == "win32":
        return None
    if hasattr(os, "memfd_create"):
        return os.fdopen(os.memfd_create(NAME), "w+b", buffering=0)
    return tempfile.TemporaryFile(buffering=0)
