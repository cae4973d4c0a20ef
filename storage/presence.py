"""Whether the folder of a workspace is where it was: a drive may be taken away, and its mount point stays behind empty."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.errors import StorageError

FSTAB: Final = Path("/etc/fstab")
"""Where Linux is told which drives belong where."""


MOUNTED: Final = Path("/proc/self/mountinfo")
"""What is mounted where, bound folders among it, which look like any other folder."""


@dataclass(slots=True)
class _Held:
    """A folder as it was when it was held first, and how many blocks hold it.

    It stays open: on FAT a folder that nobody has open may come back under another number.
    """

    found: tuple[int, int]
    opened: int | None
    blocks: int = 0


_held: Final[dict[Path, _Held]] = {}
"""Folders of the workspaces that this process works in; a stage works in another thread than the run."""

_holding: Final = threading.Lock()


@contextmanager
def held_in_place(root: Path) -> Iterator[None]:
    """Let nothing be made below a folder as long as the block lasts, once it is gone or another one.

    Else the first folder that is missing would be made anew, on the drive beneath, and a run would go on into nowhere.

    Raises
    ------
    StorageError
        If the folder is gone already.
    """
    with _holding:
        held = _held.get(root) or _opened(root)
        _held[root] = held
        held.blocks += 1
    try:
        yield
    finally:
        with _holding:
            held.blocks -= 1
            if not held.blocks:
                _held.pop(root, None)
                if held.opened is not None:
                    os.close(held.opened)


def _opened(root: Path) -> _Held:
    opened = None
    with suppress(OSError):  # Windows opens no folders, and knows them by lasting numbers
        opened = os.open(root, os.O_RDONLY)
    found = _which(root)
    if found is None:
        if opened is not None:
            os.close(opened)
        raise _gone(root)
    return _Held(found, opened)


def check_in_place(path: Path) -> None:
    """Refuse to make a file or folder where the workspace that it belongs to is gone.

    Raises
    ------
    StorageError
        With what to do.
    """
    for root, held in list(_held.items()):
        if path.is_relative_to(root) and _which(root) != held.found:
            raise _gone(root)


def check_mounted(root: Path, fstab: Path | None = None) -> None:
    """Refuse a new workspace below a mount point whose drive is not mounted.

    Only drives that the system was told of can be missed: where `fstab` names none, an empty folder is a folder.

    Raises
    ------
    StorageError
        With what to mount.
    """
    fstab = fstab or FSTAB
    for point in _mount_points(fstab):
        below = root.is_relative_to(point) or root.resolve().is_relative_to(
            point
        )  # it may lead there over a link
        if below and point != Path("/") and not _is_mounted(point):
            raise StorageError(
                f"no workspace at {root}: {point} is the place of a drive ({fstab}) and none is mounted there; "
                f"mount it (`mount {point}`) and run again, or name another folder with --workspace"
            )


def may_be_unmounted(path: Path) -> bool:
    """Whether a missing file may be on a missing drive: its folder is gone or holds nothing, as a mount point does."""
    try:
        return not any(path.parent.iterdir())
    except (FileNotFoundError, NotADirectoryError):
        return True
    except OSError:
        return False


def _is_mounted(point: Path) -> bool:
    try:
        lines = MOUNTED.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return os.path.ismount(point)
    places = {line.split()[4].replace("\\040", " ") for line in lines}
    return str(point.resolve()) in places


def _mount_points(fstab: Path) -> list[Path]:
    try:
        lines = fstab.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []  # other systems have none
    words = [line.split() for line in lines if not line.lstrip().startswith("#")]
    places = [word[1].replace("\\040", " ") for word in words if len(word) > 1]
    return [Path(place) for place in places if place.startswith("/")]


def _which(root: Path) -> tuple[int, int] | None:
    """Which folder it is; None where there is none that can be looked at."""
    try:
        found = root.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino


def _gone(root: Path) -> StorageError:
    return StorageError(
        f"the workspace {root} is gone, or its path leads to another folder than before: its drive was taken away or "
        "the folder moved; bring it back and run again: what was stored there is as it was"
    )
