"""What lies in the inbox folder of a watch, and which of it has come to rest."""

import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.errors import StorageError

SETTLE_S: Final = 10.0
"""A file whose size and time of change stay the same for so long has come to rest."""

UNFINISHED: Final = re.compile(
    r"\..*"  # rsync writes .NAME.XXXXXX, lftp and our own uploads hidden names
    r"|.*\.(part|filepart|partial|tmp|temp|crdownload|inprogress|uploading)"  # WinSCP: .filepart; rclone: .partial
    r"|.*~|~\$.*"
    r"|.*\.[0-9a-f]{8}\.partial|rclone-move-.*",
    re.IGNORECASE,
)
"""Names under which programs that transfer files keep what is not whole yet."""

Clock = Callable[[], float]


@dataclass(frozen=True, slots=True)
class InboxFile:
    """A file of the inbox; ``name`` is relative to the inbox, with forward slashes."""

    name: str
    path: Path
    size_bytes: int
    mtime_ns: int

    @property
    def stamp(self) -> tuple[int, int]:
        """Changes when the file does."""
        return self.size_bytes, self.mtime_ns


def look_into(folder: Path) -> tuple[InboxFile, ...]:
    """List the files of an inbox and its folders, sorted by name; hidden folders are passed over.

    Raises
    ------
    StorageError
        If the folder cannot be read, as while a share is away.
    """
    try:
        return tuple(sorted(_files(folder, folder), key=lambda file: file.name))
    except OSError as fault:
        raise StorageError(
            f"cannot read the inbox {folder}: {fault.strerror or fault}; check that the folder or share is there"
        ) from fault


def is_unfinished(file: InboxFile) -> bool:
    """Whether the name says that a program is still writing the file."""
    return UNFINISHED.fullmatch(file.path.name) is not None


class Settling:
    """Which files have kept size and time of change for some seconds, seen by looking at them again and again."""

    def __init__(self, settle_s: float, clock: Clock = time.monotonic) -> None:
        self._settle_s = settle_s
        self._clock = clock
        self._since: dict[str, tuple[tuple[int, int], float]] = {}

    def settled(self, files: Sequence[InboxFile]) -> frozenset[str]:
        """Names of the files that have come to rest; to be called at every look."""
        now_s = self._clock()
        self._since = {
            file.name: known if known is not None and known[0] == file.stamp else (file.stamp, now_s)
            for file, known in ((file, self._since.get(file.name)) for file in files)
        }
        return frozenset(
            name for name, (_, since_s) in self._since.items() if now_s - since_s >= self._settle_s
        )


def _files(folder: Path, inbox: Path) -> Iterator[InboxFile]:
    for path in folder.iterdir():
        try:
            if path.is_symlink():
                continue
            if path.is_dir():
                if not path.name.startswith("."):
                    yield from _files(path, inbox)
                continue
            stat = path.stat()
        except FileNotFoundError:
            # renamed or taken away since it was listed
            continue
        name = path.relative_to(inbox).as_posix()
        yield InboxFile(name, path, stat.st_size, stat.st_mtime_ns)
