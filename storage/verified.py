"""Which artifacts were hashed already and are unchanged since: hashing gigabytes on every run takes too long."""

import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.workspace import Workspace

YOUNGEST_NS: Final = 2_000_000_000
"""A file that changed within the tick of the system's clock may change again and keep its time; FAT ticks every 2 s."""

AHEAD_NS: Final = 86_400 * 1_000_000_000
"""The clock of a file server, or a local time on FAT, may be so far ahead of this machine's, and not more."""


@dataclass(frozen=True, slots=True)
class Stamp:
    """What changes when a file's content does."""

    inode: int
    size: int
    mtime_ns: int


@dataclass(slots=True)
class _Memory:
    stamps: dict[str, Stamp]
    bytes_read: int


_MEMORIES: Final[dict[Path, _Memory]] = {}
_READING: Final = threading.Lock()
"""Stages run in threads: without it two of them read the same lines on, and one finds them gone."""


def stamp_of(path: Path) -> Stamp | None:
    """Inode, size and time of change of a file; None if it is not there or the system does not let it be seen."""
    try:
        stat = path.stat()
    except (OSError, ValueError):  # a name too long or with a zero byte, a folder that may not be searched
        return None
    return Stamp(stat.st_ino, stat.st_size, stat.st_mtime_ns)


def would_show_change(stamp: Stamp) -> bool:
    """Whether a change from now on gives a file another time than it has.

    One that is dated further ahead than any clock is wrong was dated so by hand, by a scanner, or before the clock was
    set back: a change dates it back.
    """
    age_ns = time.time_ns() - stamp.mtime_ns
    return age_ns >= YOUNGEST_NS or age_ns < -AHEAD_NS


def is_remembered(ws: Workspace, path: Path) -> bool:
    """Whether the file was found whole before, by any process, and carries the same stamp since."""
    stamp = stamp_of(path)
    return stamp is not None and _recalled(ws).stamps.get(path.name) == stamp


def remember(ws: Workspace, path: Path) -> None:
    """Note that the file was found whole just now; one too young for its stamp to be trusted is not noted."""
    stamp = stamp_of(path)
    if stamp is None or not would_show_change(stamp):
        return
    # one short line appended at once: several processes may do so without a lock, and a torn line is skipped;
    # where the disk takes no more, or is read-only, the file is hashed once more another time
    with suppress(OSError), _place(ws).open("a", encoding="ascii") as file:
        file.write(f"{path.name} {stamp.inode} {stamp.size} {stamp.mtime_ns}\n")
    _recalled(ws).stamps[path.name] = stamp


def forget(ws: Workspace, path: Path) -> None:
    """Forget, in this process, that the file was whole."""
    _recalled(ws).stamps.pop(path.name, None)


def _place(ws: Workspace) -> Path:
    return ws.artifacts / "verified.txt"


def _recalled(ws: Workspace) -> _Memory:
    place = _place(ws)
    with _READING:
        memory = _MEMORIES.setdefault(ws.root, _Memory({}, 0))
        size = place.stat().st_size if place.is_file() else 0
        if size != memory.bytes_read:
            _read_on(place, memory, size)
    return memory


def _read_on(place: Path, memory: _Memory, size: int) -> None:
    if size < memory.bytes_read:
        memory.stamps, memory.bytes_read = {}, 0
    if size:
        with place.open("rb") as file:
            file.seek(memory.bytes_read)
            memory.stamps.update(
                _parse(file.read(size - memory.bytes_read).decode("ascii", errors="replace"))
            )
    memory.bytes_read = size


def _parse(text: str) -> dict[str, Stamp]:
    stamps = {}
    for line in text.splitlines():
        match line.split():
            case [name, *numbers] if len(numbers) == 3 and all(number.isdecimal() for number in numbers):
                stamps[name] = Stamp(*(int(number) for number in numbers))
    return stamps
