"""What time and hands do to a file: a bit that flips behind an unchanged date, half a file, none, a folder, another file."""

import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

Damage = Callable[[Path, Path | None], None]
"""Spoils the first file; the second is another one of its kind, where there is one."""


def flip(path: Path, _other: Path | None) -> None:
    """Flip one bit in the middle, and leave the date as a disk that rots does."""
    stat = path.stat()
    content = bytearray(path.read_bytes())
    if not content:  # a lock, or a log in which nothing is said: no bit is there to flip
        return
    content[len(content) // 2] ^= 1
    with path.open("r+b") as file:
        file.write(content)
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))


def truncate(path: Path, _other: Path | None) -> None:
    """Leave half of it."""
    os.truncate(path, path.stat().st_size // 2)


def empty(path: Path, _other: Path | None) -> None:
    """Leave nothing of it but its name."""
    os.truncate(path, 0)


def delete(path: Path, _other: Path | None) -> None:
    """Remove it."""
    path.unlink()


def to_folder(path: Path, _other: Path | None) -> None:
    """Put a folder in its place."""
    path.unlink()
    path.mkdir()


def exchange(path: Path, other: Path | None) -> None:
    """Put another whole file of its kind in its place."""
    if other is not None:
        shutil.copyfile(other, path)


DAMAGES: Final[Mapping[str, Damage]] = {
    "flipped": flip,
    "truncated": truncate,
    "emptied": empty,
    "deleted": delete,
    "folder": to_folder,
    "exchanged": exchange,
}
