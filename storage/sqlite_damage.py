"""What is wrong with a database of SQLite: the workflow engine keeps its history in one."""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Final

_DAMAGED: Final = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


def damage_of(database: Path) -> str | None:
    """What is wrong with a database of SQLite; None where it is whole, is not there, or is in use just now."""
    if not database.exists():
        return None
    if not database.is_file():
        return "it is no file"
    try:
        with closing(
            sqlite3.connect(f"{database.resolve().as_uri()}?mode=ro", uri=True, timeout=1.0)
        ) as connection:
            (said,) = connection.execute("PRAGMA quick_check(1)").fetchone()
    except sqlite3.Error as fault:
        code = getattr(fault, "sqlite_errorcode", None)
        return str(fault) if code is not None and code & 0xFF in _DAMAGED else None
    return None if said == "ok" else str(said)
