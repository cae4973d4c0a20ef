"""Names of files in an archive: those that every system takes for the same file, below the new folder."""

from pathlib import PurePosixPath
from typing import Final

from storage.ids import DEVICES

_SIGNS: Final = "\\:\0"


def is_plain(name: str) -> bool:
    """Whether a name, with forward slashes, leads to one file below where it is used, whatever the system."""
    parts = PurePosixPath(name).parts
    return bool(parts) and "/".join(parts) == name and not any(_is_odd(part) for part in parts)


def spelling(name: str) -> str:
    """What two names share that are one on Windows and macOS, where capitals tell nothing apart."""
    return name.casefold()


def _is_odd(part: str) -> bool:
    if part in ("/", "..") or any(sign in part for sign in _SIGNS) or part != part.rstrip(". "):
        return True
    return part.split(".", maxsplit=1)[0].rstrip(" ").upper() in DEVICES
