"""Move a file of an inbox to its own place: nothing is removed before a whole copy, true to its digest, is there."""

import errno
import hashlib
import os
import shutil
from pathlib import Path
from typing import BinaryIO, Final

from storage.atomic import faults_of_the_system, make_folder, replace_file, sync_folder, write_temp
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.inbox import InboxFile

CHUNK_BYTES: Final = 4 * 1024 * 1024

_NO_LINKS: Final = frozenset(
    [errno.EXDEV, errno.EPERM, errno.EACCES, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EMLINK, errno.ENOSYS]
)
"""What a system answers that cannot give a file a second name: another disk, FAT, some shares."""


def place_for_good(file: InboxFile, target: Path, sha256: str) -> None:
    """Let ``target`` hold what a file of the inbox holds, for a file that will be removed from the inbox.

    On one file system the file gets a second name, which costs nothing; else it is copied, and the copy is hashed
    while it is made. A target that holds the same already is left alone.

    Raises
    ------
    StorageError
        If the target holds something else, the file changed since it was listed, or the disk refuses.
    """
    if _holds(target, sha256):
        return
    make_folder(target.parent)
    if not _linked(file.path, target):
        _copy(file.path, target, sha256)
    elif not _is_unchanged(file):
        target.unlink()
        raise _changed(file)
    sync_folder(target.parent)


def place_copy(file: InboxFile, target: Path, sha256: str) -> None:
    """As ``place_for_good``, for a file that stays, and into which others may still write: always a copy.

    Raises
    ------
    StorageError
        If the target holds something else, the file changed since it was hashed, or the disk refuses.
    """
    if _holds(target, sha256):
        return
    make_folder(target.parent)
    _copy(file.path, target, sha256)
    sync_folder(target.parent)


def remove_placed(file: InboxFile, target: Path) -> None:
    """Remove a file from the inbox that has its whole copy at ``target``; one that changed since stays.

    Raises
    ------
    StorageError
        If the copy is not there, the file changed, or the disk refuses.
    """
    if not target.is_file() or target.stat().st_size != file.size_bytes:
        raise StorageError(f"{target} is no whole copy of {file.path}, which therefore stays")
    if not _is_unchanged(file):
        raise _changed(file)
    with faults_of_the_system(file.path):
        file.path.unlink(missing_ok=True)
    sync_folder(file.path.parent)


def _holds(target: Path, sha256: str) -> bool:
    if not target.exists():
        return False
    if not target.is_file() or file_sha256(target) != sha256:
        raise StorageError(f"{target} is there already and holds something else; move it away")
    return True


def _is_unchanged(file: InboxFile) -> bool:
    try:
        stat = file.path.stat()
    except FileNotFoundError:
        return False
    return (stat.st_size, stat.st_mtime_ns) == file.stamp


def _changed(file: InboxFile) -> StorageError:
    return StorageError(f"{file.path} changed while it was taken in; it stays and is looked at again")


def _linked(source: Path, target: Path) -> bool:
    try:
        os.link(source, target)
    except OSError as fault:
        if fault.errno in _NO_LINKS:
            return False
        with faults_of_the_system(target):
            raise
    return True


def _copy(source: Path, target: Path, sha256: str) -> None:
    digest = hashlib.sha256()

    def write(out: BinaryIO) -> None:
        with source.open("rb") as file:
            while chunk := file.read(CHUNK_BYTES):
                digest.update(chunk)
                out.write(chunk)

    temp = write_temp(target, write)
    if digest.hexdigest() != sha256:
        temp.unlink()
        raise StorageError(f"{source} changed while it was copied; it stays and is looked at again")
    shutil.copystat(source, temp)
    replace_file(temp, target)
