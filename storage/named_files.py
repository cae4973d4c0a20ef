"""Files that a user names to write to: links are followed, devices and pipes are written to and stay what they are."""

import io
import os
import stat
from pathlib import Path

from storage.atomic import Writer, faults_of_the_system, write_atomically
from storage.errors import StorageError


def write_named_file(path: Path, content: bytes | Writer) -> None:
    """Write to what a user named: a file appears whole or not at all.

    Raises
    ------
    StorageError
        If it is a folder, or the system refuses.
    """
    mode = _mode(path)
    if mode is None or stat.S_ISREG(mode):
        write_atomically(Path(os.path.realpath(path)), content)
    elif stat.S_ISDIR(mode):
        raise StorageError(f"cannot write {path}: it is a folder; name a file in it")
    else:
        _write_straight(path, content)


def _mode(path: Path) -> int | None:
    """Kind of what is there, at the end of links; None where nothing is."""
    try:
        with faults_of_the_system(path):
            return path.stat().st_mode
    except StorageError as fault:
        if isinstance(fault.__cause__, FileNotFoundError):
            return None
        raise


def _write_straight(path: Path, content: bytes | Writer) -> None:
    whole = io.BytesIO()  # neither can seek, which LAS needs
    if isinstance(content, bytes):
        whole.write(content)
    else:
        content(whole)
    with faults_of_the_system(path), path.open("wb", buffering=0) as file:
        rest = whole.getbuffer()
        while rest:
            rest = rest[file.write(rest) :]
