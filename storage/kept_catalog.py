"""Catalogs that stay open between readings, for a program that reads all day: to open one takes 50 ms, to ask it 3."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Final

import duckdb

from storage.catalog_stamp import stamp_of_file

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
    """Keep a catalog open no longer; who reads it now reads on."""
    with _LOCK:
        _KEPT.pop(catalog, None)


def kept_cursor(catalog: Path, opened: Open) -> duckdb.DuckDBPyConnection | None:
    """Return a cursor of the open catalog, for the caller to close; None where it is not one that is kept.

    A file that was replaced is opened anew. The one before is not closed but let go: to close a connection closes the
    cursors that others read from just now; it goes with the last of them.

    Parameters
    ----------
    opened : callable
        Opens the catalog.
    """
    with _LOCK:
        kept = _KEPT.get(catalog)
        if kept is None:
            return None
        # within the lock, or a thread that was late would bring an old stamp
        stamp = stamp_of_file(catalog)
        if kept.connection is None or kept.stamp != stamp:
            kept.connection, kept.stamp = opened(), stamp
        return kept.connection.cursor()
