"""Where a scan that the campaign file names lies, and whether it may lie there."""

import os
from collections.abc import Sequence
from pathlib import Path

from storage.errors import InputError


def resolve_scan(scan: str, folder: Path, roots: Sequence[str]) -> Path:
    """Resolve a scan's path, following links, and hold it inside the allowed folders.

    Parameters
    ----------
    scan
        Path as the campaign file has it: relative to ``folder``, or absolute within a root.
    folder
        Folder of the campaign file.
    roots
        Folders of [files] roots, absolute or relative to ``folder``.

    Raises
    ------
    InputError
        If the file would lie elsewhere, or its path cannot be followed.
    """
    path = _follow(folder / scan, scan)
    allowed = [_follow(folder, str(folder)), *(_follow(folder / root, root) for root in roots)]
    if not any(path.is_relative_to(place) for place in allowed):
        places = ", ".join(str(place) for place in allowed)
        raise InputError(f"{scan!r} lies outside the allowed folders ({places})")
    return path


def same_file_key(path: Path) -> str:
    """Return a key that is equal for two spellings of one resolved path on this system."""
    return os.path.normcase(path)


def _follow(path: Path, name: str) -> Path:
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(f"{name!r} cannot be followed: {error}") from error
