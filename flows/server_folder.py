"""The folder of a workflow server: its owner's alone, and what lies there is made fit before one starts."""

import re
import stat
from contextlib import suppress
from pathlib import Path
from typing import Final

from flows.terminal import note
from storage.atomic import make_folder, move_out_of_the_way
from storage.errors import StorageError
from storage.sqlite_damage import damage_of

DATABASE: Final = "prefect.db"

BESIDE: Final = (f"{DATABASE}-wal", f"{DATABASE}-shm")
"""What SQLite keeps beside it; of no use to another database."""


def make_private(folder: Path) -> None:
    """Make the folder of a server, or take what others may do in it away: its database says what was run with what."""
    make_folder(folder)
    if stat.S_IMODE(folder.stat().st_mode) & 0o077:
        with suppress(PermissionError):  # that of another user: who may use it is for him to say
            folder.chmod(0o700)


def make_fit(folder: Path) -> None:
    """Sweep what killed servers left, and set a damaged database aside; nobody else may start a server meanwhile."""
    _sweep_unfinished_records(folder)
    _set_aside_a_damaged_database(folder)


def _sweep_unfinished_records(folder: Path) -> None:
    """Remove what servers left that were killed while they wrote their record.

    Who starts one holds the lock until it answers: one that writes now has lost whoever started it, and is not needed.
    """
    for path in folder.glob("server.*"):
        if re.fullmatch(r"server\.[0-9a-f]{16}", path.name):
            with suppress(OSError):
                path.unlink()


def _set_aside_a_damaged_database(folder: Path) -> None:
    """A server would start on it and then fail in the middle of a run; no result rests on it, so a new one does as well."""
    database = folder / DATABASE
    damage = damage_of(database)
    if damage is None:
        return
    with suppress(StorageError):  # the server then says itself that it cannot start
        for name in BESIDE:  # first: a new database must not find them
            if (folder / name).exists():
                move_out_of_the_way(folder / name)
        kept = move_out_of_the_way(database)
        note(
            f"the history of flow runs {database} is damaged ({damage}): it is kept as {kept.name}, and a new one begun; "
            "no result rests on it"
        )
