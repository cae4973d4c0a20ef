"""What a machine holds of a store that lies elsewhere: files by their digest, the longest unused thrown out.

All stores share one cache: a file is known by its digest. It is a folder of this machine (``TILTWATCH_CACHE``, else
``~/.cache/tiltwatch``) and holds at most ``TILTWATCH_CACHE_GB`` (20), or what was used in the last ten minutes if that is
more: a stage may be reading it. What was used in the future, as the clock has it that was set back since, was not used
since then, and goes first.
"""

import math
import os
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from storage.atomic import TEMP_SUFFIX
from storage.errors import StorageError
from storage.folder_store import FolderStore
from storage.store import Content

FOLDER_VARIABLE: Final = "TILTWATCH_CACHE"
LIMIT_VARIABLE: Final = "TILTWATCH_CACHE_GB"
LIMIT_GB: Final = 20.0
IN_USE_S: Final = 600.0

# the folder is looked through when this share of the limit has come in since
_LOOK_SHARE: Final = 0.05
_MEMORY_BYTES: Final = 16_000_000

# a temp of a process that was killed; no download takes a day
_ABANDONED_S: Final = 86_400.0


@dataclass(slots=True)
class StoreCache:
    """A folder that holds no more than ``limit_bytes``, but for what was used in the last ``in_use_s`` seconds."""

    root: Path
    limit_bytes: int
    in_use_s: float = IN_USE_S
    _came_in: int = field(default=0, init=False)
    _looking: threading.Lock = field(default_factory=threading.Lock, init=False, repr=False)

    @property
    def incoming(self) -> Path:
        """What temps that shall be taken in are named after."""
        return self._held.incoming

    def find(self, name: str, content: Content) -> Path | None:
        """Give a file that is here whole, and note its use; None where it is not."""
        if not self._held.is_whole(name, content):
            return None
        path = self.root / name
        # another process may throw it out at this moment
        with suppress(FileNotFoundError):
            os.utime(path, ns=(time.time_ns(), path.stat().st_mtime_ns))
            return path
        return None

    def take(self, name: str, temp: Path, content: Content) -> Path:
        """Move a finished temp in, and make room for what comes next."""
        self._held.take(name, temp, content)
        path = self.find(name, content)
        if path is None:
            raise StorageError(f"{self.root / name} vanished from the cache as it was stored; run again")
        with self._looking:
            self._came_in += content.size
            if self._came_in > _LOOK_SHARE * self.limit_bytes:
                self._came_in = 0
                self.make_room()
        return path

    def make_room(self) -> None:
        """Throw out what was unused for longest until the rest is within the limit."""
        memory = self.root / "artifacts" / "verified.txt"
        with suppress(FileNotFoundError):
            # it has a line for every file that was ever here; without it those that are here are hashed once more
            if memory.stat().st_size > _MEMORY_BYTES:
                memory.unlink()
        for temp in self.root.glob(f"artifacts/*{TEMP_SUFFIX}"):
            with suppress(FileNotFoundError):
                if abs(time.time() - temp.stat().st_mtime) > _ABANDONED_S:
                    temp.unlink()
        now_s = time.time()
        used = []
        for path in self.root.glob("artifacts/*/*"):
            with suppress(FileNotFoundError):
                stat = path.stat()
                used.append((_age_s(stat.st_atime, now_s, self.in_use_s), stat.st_size, path))
        too_much = sum(size for _, size, _ in used) - self.limit_bytes
        for age_s, size, path in sorted(used, reverse=True):
            if too_much <= 0 or age_s < self.in_use_s:
                return
            path.unlink(missing_ok=True)
            too_much -= size

    @property
    def _held(self) -> FolderStore:
        return FolderStore(self.root)


def _age_s(last_use_s: float, now_s: float, in_use_s: float) -> float:
    """How long ago a file was used; for ever where that lies further ahead than ``in_use_s``."""
    age_s = now_s - last_use_s
    return math.inf if age_s < -in_use_s else age_s


def cache_of_machine() -> StoreCache:
    """Open the cache of this machine.

    Raises
    ------
    StorageError
        If the limit in the environment is no number above 0.
    """
    text = os.environ.get(LIMIT_VARIABLE, "")
    try:
        limit_gb = float(text or LIMIT_GB)
    except ValueError:
        limit_gb = 0.0
    if not 0.0 < limit_gb < float("inf"):
        raise StorageError(f"{LIMIT_VARIABLE} needs a number of gigabytes above 0; got {text!r}")
    return StoreCache(_folder(), int(limit_gb * 1e9))


def _folder() -> Path:
    named = os.environ.get(FOLDER_VARIABLE)
    if named:
        return Path(named).expanduser().resolve()
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "tiltwatch"
