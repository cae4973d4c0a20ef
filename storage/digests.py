"""SHA-256 of files and texts."""

import hashlib
from pathlib import Path

from storage.errors import StorageError


def file_sha256(path: Path) -> str:
    """SHA-256 of a file of any size, in hex; the file is read in pieces.

    Raises
    ------
    StorageError
        If the file cannot be read.
    """
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as fault:
        raise StorageError(f"cannot read {path}: {fault.strerror}") from fault


def text_sha256(text: str) -> str:
    """SHA-256 of a text in UTF-8, in hex."""
    return hashlib.sha256(text.encode()).hexdigest()
