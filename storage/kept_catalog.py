"""Catalogs that stay open between readings, for a program that reads all day: to open one takes 50 ms, to ask it 3."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Final

import duckdb

Open = Callable[[], duckdb.DuckDBPyConnection]


@dataclass(slots=True)
class _Kept:
    """A catalog that is open, and what told it from any other when it was opened."""

    stamp: str | None = None
    connection: duckdb.DuckDBPyConnection | None = None


_KEPT: Final[dict[Path, _Kept]] = {}
_LOCK: Final = Lock()


def keep_open(catalog: Path) -> None:
    """Keep a catalog open from its next reading on, and open it anew whenever it was replaced.

    Not on Windows: there a file that is open cannot be replaced, and the pipeline must never wait for a reader.
    """
    if os.name == "posix":
        with _LOCK:
            _KEPT.setdefault(catalog, _Kept())


def close_kept(catalog: Path) -> None:
    """Close a catalog that was kept open; it is not kept any more."""
    with _LOCK:
        kept = _KEPT.pop(catalog, None)
    if kept is not None and kept.connection is not None:
        kept.connection.close()


def kept_cursor(catalog: Path, stamp: str | None, opened: Open) -> duckdb.DuckDBPyConnection | None:
    """Return a cursor of the open catalog, for the caller to close; None where it is not one that is kept.

    Parameters
    ----------
    stamp : str
        What tells the present file from any other one; another than before has it opened anew. Cursors of the file
        before go on with what they see.
    opened : callable
        Opens it.
    """
    with _LOCK:
        kept = _KEPT.get(catalog)
        if kept is None:
            return None
        if kept.connection is None or kept.stamp != stamp:
            before, kept.connection = kept.connection, opened()
            kept.stamp = stamp
            if before is not None:
                before.close()
        return kept.connection.cursor()
