"""Every change of names in a workspace as a step, at which a process can be killed: Python tells them to audit hooks.

A step is told before it is done: one that opens a file to write, renames, links, removes, or makes a folder; and a file
whose content is brought down to the disk. What native code writes (the database of the catalog) shows by its rename.
"""

import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

CHANGES: Final = {"os.rename", "os.link", "os.remove", "os.mkdir", "os.rmdir"}

WRITES: Final = os.O_WRONLY | os.O_RDWR | os.O_CREAT


def kill_this_process() -> None:
    """Die as by the power cut."""
    os.kill(os.getpid(), signal.SIGKILL)


@dataclass(slots=True)
class Steps:
    """Counts the steps in a workspace, and kills this process before the one that was asked for (from 1; 0: never)."""

    root: Path
    kill_at: int
    done: list[str] = field(default_factory=list)
    deed: Callable[[], None] = kill_this_process
    """What is done instead of the kill, by tests of other faults."""
    pause_s: float = 0.0
    """So long every step takes longer."""

    def watch(self) -> None:
        """Begin to count; it cannot be ended."""
        sync = os.fsync

        def told_sync(handle: int) -> None:
            self._step("fsync", Path(f"/proc/self/fd/{handle}").readlink())
            sync(handle)

        os.fsync = told_sync  # type: ignore[assignment]
        sys.addaudithook(self._hear)

    def _hear(self, event: str, words: tuple[Any, ...]) -> None:
        if event in CHANGES or (event == "open" and isinstance(words[2], int) and words[2] & WRITES):
            self._step(event, words[0])

    def _step(self, event: str, path: object) -> None:
        if not isinstance(path, str | os.PathLike):
            return
        place = os.fspath(path)
        if not place.startswith(f"{self.root}/") or "/prefect/" in place or "/locks/" in place:
            return
        self.done.append(f"{event} {place[len(str(self.root)) + 1 :]}")
        if 0 < self.kill_at <= len(self.done):  # another thread may have taken a step meanwhile
            self.kill_at = 0
            self.deed()
        time.sleep(self.pause_s)
