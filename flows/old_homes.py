"""Homes of workflow servers that no machine has used for long: each container brings a name of its own, and a home."""

import shutil
import time
from contextlib import suppress
from pathlib import Path
from typing import Final

from filelock import Timeout

from flows.workflow_server import server_lock

UNUSED_S: Final = 60 * 86_400.0
"""What lies there is the history of flow runs, which nothing of ours rests on."""


def sweep_old_homes(folder: Path, own: Path) -> None:
    """Remove the homes beside one's own that were not used for ``UNUSED_S``; one that is in use stays."""
    for home in folder.iterdir() if folder.is_dir() else ():
        if home == own or not home.is_dir() or not _is_abandoned(home):
            continue
        with suppress(Timeout, OSError, NotImplementedError), server_lock(home).acquire(timeout=0):
            shutil.rmtree(home, ignore_errors=True)


def _is_abandoned(home: Path) -> bool:
    """Whether nothing changed in a home for long; not known of that of another user, or of one that is just removed."""
    try:
        # dated far ahead: the clock was set back since
        return abs(time.time() - _last_used_s(home)) >= UNUSED_S
    except (PermissionError, FileNotFoundError):
        return False


def _last_used_s(home: Path) -> float:
    """When anything in a home changed last, seconds since 1970."""
    times = [home.stat().st_mtime]
    for path in home.iterdir():
        with suppress(OSError):
            times.append(path.stat().st_mtime)
    return max(times)
