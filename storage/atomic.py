"""Files that are either there whole or not there: temp beside, fsync, rename."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final
from uuid import uuid4

from storage.errors import StorageError
from storage.presence import check_in_place
from storage.writers import mark_of_this_process

Writer = Callable[[BinaryIO], None]

# DuckDB's globs match "*.parquet" with a leading dot too, so a temp must not end in .parquet
TEMP_SUFFIX: Final = ".tmp"

SET_ASIDE_SUFFIX: Final = ".bad"
"""Of what was damaged and is kept for whoever wants to look at it."""

# Windows refuses to replace a file that a virus scanner or a reader holds open for a moment
_REPLACE_PAUSES_S: Final = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8)


def write_atomically(path: Path, content: bytes | Writer) -> None:
    """Write a file so that a crash at any time leaves the old one or the new one, whole.

    Parameters
    ----------
    path : Path
        The file; its folder is made if need be.
    content : bytes or callable
        The bytes, or a function that writes them to the binary file that it is given.

    Raises
    ------
    StorageError
        If the system refuses, as for a full disk.
    """
    temp = write_temp(path, content)
    try:
        replace_file(temp, path)
    except BaseException:
        temp.unlink(missing_ok=True)
        raise
    sync_folder(path.parent)


def write_our_own(path: Path, content: bytes | Writer) -> None:
    """Write a file of a workspace atomically; a folder that stands in its place is moved out of the way.

    Raises
    ------
    StorageError
        If the system refuses, as for a full disk.
    """
    clear_place(path)
    write_atomically(path, content)


def clear_place(path: Path) -> None:
    """Move a folder out of the way that stands where a file of a workspace belongs."""
    if path.is_dir() and not path.is_symlink():
        move_out_of_the_way(path)


def write_temp(path: Path, content: bytes | Writer) -> Path:
    """Write what shall become ``path`` to a temp in the same folder, down to the disk; return the temp."""
    make_folder(path.parent)
    temp = temp_beside(path)
    try:
        with faults_of_the_system(path), temp.open("xb") as file:
            if isinstance(content, bytes):
                file.write(content)
            else:
                content(file)
            file.flush()
            os.fsync(file.fileno())
    except BaseException:
        temp.unlink(missing_ok=True)
        raise
    return temp


def temp_beside(path: Path) -> Path:
    """A new name in the folder of ``path``, which no reader takes for a finished file; it tells who writes it."""
    return path.with_name(f"{path.name}.{mark_of_this_process()}.{uuid4().hex}{TEMP_SUFFIX}")


def replace_file(temp: Path, path: Path) -> None:
    """Rename ``temp`` onto ``path``, patiently where Windows refuses for a moment.

    Raises
    ------
    StorageError
        If the file is still held open, or the system refuses for another reason.
    """
    for pause_s in _REPLACE_PAUSES_S:
        try:
            temp.replace(path)
        except PermissionError:
            time.sleep(pause_s)
        except OSError:
            break
        else:
            return
    with faults_of_the_system(path):
        temp.replace(path)


def move_out_of_the_way(path: Path) -> Path:
    """Rename what is no use where it is, so that nobody reads it there; return where it lies now.

    Raises
    ------
    StorageError
        If the system refuses.
    """
    aside = path.with_name(f"{path.name}.{uuid4().hex}{SET_ASIDE_SUFFIX}")
    with faults_of_the_system(path):
        path.rename(aside)
    return aside


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, down to the disk; not that of a workspace which is gone under a run.

    Raises
    ------
    StorageError
        If the system refuses, or the drive was taken away.
    """
    check_in_place(folder)
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    with faults_of_the_system(folder):
        # one after the other and none above: a drive may be taken away just now
        for place in reversed(missing):
            place.mkdir(exist_ok=True)
        if not missing and not folder.is_dir():
            folder.mkdir()
    for place in missing:
        sync_folder(place.parent)


def sync_folder(folder: Path) -> None:
    """Bring the names in a folder down to the disk, where the system can (Windows cannot)."""
    if os.name == "nt":
        return
    with faults_of_the_system(folder):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def sync_file(path: Path) -> None:
    """Bring the content of a file that another library wrote down to the disk."""
    with faults_of_the_system(path), path.open("rb+") as file:
        os.fsync(file.fileno())


@contextmanager
def faults_of_the_system(path: Path) -> Iterator[None]:
    """Turn a fault of the operating system into a StorageError that names the file and the way out."""
    try:
        yield
    except PermissionError as fault:
        raise StorageError(
            f"cannot write {path}: {fault.strerror}; the folder must be writable, and on Windows no other "
            "program may hold the file open: close it there and run again"
        ) from fault
    except OSError as fault:
        raise StorageError(
            f"cannot write {path}: {fault.strerror}; put that right (free space, a writable folder) and run again"
        ) from fault
