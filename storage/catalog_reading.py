"""Catalogs opened for reading: the newest one, or one and the same, shut in so that what is in them reaches no file."""

import errno
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Final

import duckdb

from storage.errors import StorageError
from storage.kept_catalog import kept_cursor
from storage.workspace import Workspace

CLOSED: Final[dict[str, str | bool | int | float | list[str]]] = {
    "autoinstall_known_extensions": "false",
    "autoload_known_extensions": "false",
}
"""Nothing is loaded or fetched because a file asks for it."""

_NO_ROOM: Final = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG)
"""Faults of a drive that no program has to be closed for."""

_FIXED: Final[ContextVar[Mapping[Path, duckdb.DuckDBPyConnection]]] = ContextVar("one catalog", default={})  # noqa: B039
"""What a thread reads from while it is in ``one_catalog``; replaced and never changed."""


_INSTEAD: Final[dict[Path, Path]] = {}
"""Catalogs that cannot be changed, and what is read in the place of each."""


def read_instead(catalog: Path, other: Path) -> None:
    """Let this process read another file wherever it would read a catalog, which may lie where nobody can write."""
    _INSTEAD[catalog] = other


@contextmanager
def read_catalog(ws: Workspace) -> Iterator[duckdb.DuckDBPyConnection]:
    """Open the newest catalog read-only; times are shown in UTC.

    The file is attached to a database in memory: a plain ``duckdb.connect`` would show this process the file that
    it opened first, even after that was replaced, until all its connections are closed.

    Raises
    ------
    StorageError
        If there is no catalog or it cannot be read.
    """
    catalog = _INSTEAD.get(ws.catalog, ws.catalog)
    if not catalog.is_file():
        raise StorageError(
            f"no catalog at {ws.catalog}; process the campaign first with `tiltwatch run FILE`"
        )
    fixed = _FIXED.get().get(ws.catalog)
    found = kept_cursor(ws.catalog, lambda: opened_catalog(catalog)) if fixed is None else fixed.cursor()
    connection = opened_catalog(catalog) if found is None else found
    try:
        # a cursor begins anew with both
        connection.execute("USE catalog")
        connection.execute("SET TimeZone = 'UTC'")
        yield connection
    finally:
        connection.close()


@contextmanager
def one_catalog(ws: Workspace) -> Iterator[None]:
    """Have all readings of this thread see one catalog: what belongs together is read together.

    Without it every reading opens the newest, and an epoch that is published between two is in the one and not in the
    other.

    Raises
    ------
    StorageError
        If there is no catalog or it cannot be read.
    """
    with read_catalog(ws) as connection:
        before = _FIXED.set({**_FIXED.get(), ws.catalog: connection})
        try:
            yield
        finally:
            _FIXED.reset(before)


def opened_catalog(catalog: Path, beside: Path | None = None) -> duckdb.DuckDBPyConnection:
    """Attach a catalog to a database in memory, and another one as ``fresh`` where it is to be held against it.

    Raises
    ------
    StorageError
        If one cannot be read.
    """
    connection = duckdb.connect(config=CLOSED)
    try:
        attach(connection, catalog, "catalog", "READ_ONLY")
        if beside is not None:
            attach(connection, beside, "fresh", "READ_ONLY")
    except StorageError:
        connection.close()
        raise
    shut_in(connection)
    return connection


def shut_in(connection: duckdb.DuckDBPyConnection) -> None:
    """Let a connection reach nothing but what is attached: a catalog may come from others, and its views are theirs."""
    connection.execute("SET python_enable_replacements = false")
    # for good: no view and no statement can take it back
    connection.execute("SET enable_external_access = false")


def attach(connection: duckdb.DuckDBPyConnection, path: Path, name: str, option: str) -> None:
    """Attach the file of a catalog under a name.

    Raises
    ------
    StorageError
        If it cannot be opened.
    """
    quoted = str(path).replace("'", "''")
    try:
        connection.execute(f"ATTACH '{quoted}' AS {name} ({option})")
    except duckdb.Error as fault:
        raise StorageError(
            f"cannot open {path}: {str(fault).splitlines()[0]}; {_what_to_do(str(fault))}"
        ) from fault


def _what_to_do(fault: str) -> str:
    if any(os.strerror(number) in fault for number in _NO_ROOM):
        return "put that right (free space, a writable folder) and run again"
    return "close the program that writes to it, or delete it and run again: it is rebuilt from the tables"
