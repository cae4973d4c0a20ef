"""What is wrong with a database of SQLite: the workflow engine keeps its history in one."""

import sqlite3
import time
from contextlib import closing
from pathlib import Path
from typing import Final

LONGEST_S: Final = 10.0
"""A database so large, or on so slow a drive, that it takes longer is left unlooked at."""

_OF_CONTENT: Final = ("NULL value in", "CHECK constraint failed")
"""What a program wrote against its own rules, and no disk."""

_DAMAGED: Final = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


def damage_of(database: Path) -> str | None:
    """What is wrong with a database of SQLite; None where it is whole, is not there, is in use just now, or takes long."""
    if not database.exists():
        return None
    if not database.is_file():
        return "it is no file"
    try:
        with closing(
            sqlite3.connect(f"{database.resolve().as_uri()}?mode=ro", uri=True, timeout=1.0)
        ) as connection:
            patient_until = time.monotonic() + LONGEST_S
            connection.set_progress_handler(lambda: time.monotonic() > patient_until, 100_000)
            said = [str(row[0]) for row in connection.execute("PRAGMA quick_check")]
    except sqlite3.Error as fault:
        code = getattr(fault, "sqlite_errorcode", None)
        return str(fault) if code is not None and code & 0xFF in _DAMAGED else None
    return next((line for line in said if line != "ok" and not line.startswith(_OF_CONTENT)), None)
