"""The folder of a workflow server: its owner's alone, and free of what dead servers left."""

import re
import stat
from contextlib import suppress
from pathlib import Path

from storage.atomic import make_folder


def make_private(folder: Path) -> None:
    """Make the folder of a server, or take what others may do in it away: its database says what was run with what."""
    make_folder(folder)
    if stat.S_IMODE(folder.stat().st_mode) & 0o077:
        with suppress(PermissionError):  # that of another user: who may use it is for him to say
            folder.chmod(0o700)


def sweep_unfinished_records(folder: Path) -> None:
    """Remove what servers left that were killed while they wrote their record.

    Who starts one holds the lock until it answers: one that writes now has lost whoever started it, and is not needed.
    """
    for path in folder.glob("server.*"):
        if re.fullmatch(r"server\.[0-9a-f]{16}", path.name):
            with suppress(OSError):
                path.unlink()
