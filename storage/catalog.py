"""The catalog: one DuckDB file that holds all rows and the views of the contract, made anew from the Parquet."""

import hashlib
import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

import duckdb

from storage.atomic import faults_of_the_system, replace_file, sync_file, sync_folder, temp_beside
from storage.catalog_content import (
    copy_rows,
    create_table,
    create_view,
    fill_dictionary,
    read_rows_in,
    remove_rows,
)
from storage.catalog_parts import CATALOG_TABLES, Part, part_of, stamps_of
from storage.errors import StorageError
from storage.kept_catalog import kept_cursor
from storage.locks import publish_lock
from storage.publish import recover
from storage.records import columns_of
from storage.view_definitions import VIEWS, view_definition
from storage.workspace import Workspace

# a file of DuckDB 2's own default is refused by every 1.x client
STORAGE_VERSION: Final = "v1.0.0"


# rows that were replaced in a copy of a catalog leave holes: of more files than so many, or than this share of all,
# it is made anew
_FEW_FILES: Final = 1000
_MOST_REPLACED: Final = 0.25


_FIXED: Final[ContextVar[Mapping[Path, duckdb.DuckDBPyConnection]]] = ContextVar("one catalog", default={})  # noqa: B039
"""What a thread reads from while it is in ``one_catalog``; replaced and never changed."""


@dataclass(frozen=True, slots=True)
class Sources:
    """All that a catalog is made of."""

    definitions: str
    """Digest of the views, the columns and the version of DuckDB."""
    columns: Mapping[str, str]
    """Table to the digest of its columns: where it is the same, rows can be taken over from an older catalog."""
    stamps: Mapping[str, str]
    """File, relative to the workspace, to its inode, size and time of change."""


@dataclass(frozen=True, slots=True)
class _Stored:
    """What the present catalog was made of, and how many files were replaced in it since it was made anew."""

    sources: Sources
    replaced: int


@dataclass(frozen=True, slots=True)
class _Difference:
    """What of the sources changed: files whose rows must go, and files that must be read."""

    gone: Sequence[str]
    new: Sequence[str]
    kept: Sequence[str]


def rebuild_catalog(ws: Workspace) -> bool:
    """Make the catalog anew from the tables and put it in place at once; readers keep what they have open.

    Rows of files that did not change are taken over from the old catalog: reading a thousand epochs takes long.

    Returns
    -------
    bool
        False if nothing changed since the last time; then nothing is written.

    Raises
    ------
    StorageError
        If a table is damaged, the disk refuses, or (on Windows) a reader holds the old catalog open for long.
    """
    with publish_lock(ws):
        recover(ws)
        old, new = _stored(ws), _sources(ws)
        if old is not None and old.sources == new:
            return False
        temp = temp_beside(ws.tmp / ws.catalog.name)
        try:
            _build(ws, temp, old, new)
            sync_file(temp)
            _put_in_place(ws, temp)
        finally:
            _remove_database(temp)
    return True


def is_current(ws: Workspace) -> bool:
    """Whether the catalog can be read and was made of the tables as they are."""
    stored = _stored(ws)
    return stored is not None and stored.sources == _sources(ws)


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
    if not ws.catalog.is_file():
        raise StorageError(
            f"no catalog at {ws.catalog}; process the campaign first with `tiltwatch run FILE`"
        )
    fixed = _FIXED.get().get(ws.catalog)
    found = kept_cursor(ws.catalog, lambda: _opened(ws.catalog)) if fixed is None else fixed.cursor()
    connection = _opened(ws.catalog) if found is None else found
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


def _opened(catalog: Path) -> duckdb.DuckDBPyConnection:
    """Attach a catalog to a database in memory.

    Raises
    ------
    StorageError
        If it cannot be read.
    """
    connection = duckdb.connect()
    try:
        _attach(connection, catalog, "catalog", "READ_ONLY")
    except StorageError:
        connection.close()
        raise
    return connection


def _sources(ws: Workspace) -> Sources:
    return Sources(_definitions(), _columns(), stamps_of(ws))


@cache
def _definitions() -> str:
    sql = {name: view_definition(name).sql for name in VIEWS}
    meanings = {name: repr(list(columns_of(record))) for name, record in VIEWS.items()}
    return _digest([sql, meanings, duckdb.__version__])


@cache
def _columns() -> Mapping[str, str]:
    return {
        table: _digest(
            [(column.name, str(column.python_type), column.nullable) for column in columns_of(record)]
        )
        for table, record in CATALOG_TABLES.items()
    }


def _digest(content: object) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _stored(ws: Workspace) -> _Stored | None:
    """What the present catalog was made of; None if there is no catalog that can be read."""
    try:
        with read_catalog(ws) as connection:
            row = connection.execute(
                "SELECT definitions, columns, stamps, replaced FROM data.made_of"
            ).fetchone()
    except (StorageError, duckdb.Error):
        return None
    return None if row is None else _Stored(Sources(row[0], json.loads(row[1]), json.loads(row[2])), row[3])


def _attach(connection: duckdb.DuckDBPyConnection, path: Path, name: str, option: str) -> None:
    quoted = str(path).replace("'", "''")
    try:
        connection.execute(f"ATTACH '{quoted}' AS {name} ({option})")
    except duckdb.Error as fault:
        raise StorageError(
            f"cannot open {path}: {str(fault).splitlines()[0]}; close the program that writes to it, or delete it "
            "and run again: it is rebuilt from the tables"
        ) from fault


def _build(ws: Workspace, temp: Path, old: _Stored | None, new: Sources) -> None:
    """Make the catalog in the cheapest way; a damaged old one is found out only when its rows are taken."""
    try:
        if old is not None and _may_be_changed(old, new):
            _change_a_copy(ws, temp, old, new)
        else:
            _make(ws, temp, old, new)
    except duckdb.Error:
        if old is None:
            raise
        _remove_database(temp)
        _make(ws, temp, None, new)


def _may_be_changed(old: _Stored, new: Sources) -> bool:
    """Whether a copy of the old catalog is nearly what is wanted."""
    if old.sources.definitions != new.definitions:
        return False
    replaced = old.replaced + len(_difference(old.sources, new).gone)
    return replaced <= max(_FEW_FILES, _MOST_REPLACED * len(new.stamps))


def _difference(old: Sources, new: Sources) -> _Difference:
    kept = [file for file, stamp in new.stamps.items() if old.stamps.get(file) == stamp]
    same = frozenset(kept)
    return _Difference(
        gone=[file for file in old.stamps if file not in same],
        new=[file for file in new.stamps if file not in same],
        kept=kept,
    )


def _change_a_copy(ws: Workspace, temp: Path, old: _Stored, new: Sources) -> None:
    """Copy the old catalog and change the rows of the files that changed: most of a large one stays as it is."""
    difference = _difference(old.sources, new)
    gone, incoming = _by_table(ws, difference.gone), _by_table(ws, difference.new)
    with faults_of_the_system(temp):
        shutil.copyfile(ws.catalog, temp)
    with _building(temp) as connection:
        for table in CATALOG_TABLES:
            if table in gone:
                remove_rows(connection, table, gone[table])
            if table in incoming:
                read_rows_in(connection, table, incoming[table])
        connection.execute("DELETE FROM data.made_of")
        _note(connection, new, old.replaced + len(difference.gone))


def _make(ws: Workspace, temp: Path, old: _Stored | None, new: Sources) -> None:
    """Make a catalog anew; rows of unchanged files come from the old one where a table has the same columns."""
    difference = _Difference((), tuple(new.stamps), ()) if old is None else _difference(old.sources, new)
    same = frozenset() if old is None else old.sources.columns.items() & new.columns.items()
    kept, incoming = _by_table(ws, difference.kept), _by_table(ws, difference.new)
    with _building(temp) as connection:
        if old is not None:
            _attach(connection, ws.catalog, "old", "READ_ONLY")
        connection.execute("CREATE SCHEMA data")
        for table in CATALOG_TABLES:
            create_table(connection, table)
            known = kept.get(table, []) if (table, new.columns[table]) in same else []
            if known:
                copy_rows(connection, table, known)
            others = [] if known else kept.get(table, [])
            read_rows_in(connection, table, [*others, *incoming.get(table, [])])
        for view in VIEWS:
            create_view(connection, view)
        fill_dictionary(connection)
        connection.execute(
            "CREATE TABLE data.made_of (definitions VARCHAR, columns VARCHAR, stamps VARCHAR, replaced BIGINT)"
        )
        _note(connection, new, 0)


@contextmanager
def _building(temp: Path) -> Iterator[duckdb.DuckDBPyConnection]:
    connection = duckdb.connect()
    try:
        _attach(connection, temp, "catalog", f"STORAGE_VERSION '{STORAGE_VERSION}'")
        connection.execute("USE catalog")
        connection.execute("BEGIN")  # else each of some hundred comments is brought to the disk by itself
        yield connection
        connection.execute("COMMIT")
        connection.execute("USE memory")
        connection.execute("DETACH catalog")  # writes everything into the one file
    finally:
        connection.close()


def _by_table(ws: Workspace, files: Sequence[str]) -> dict[str, list[Part]]:
    parts: dict[str, list[Part]] = {}
    for file in files:
        part = part_of(ws, file)
        parts.setdefault(part.table, []).append(part)
    return parts


def _note(connection: duckdb.DuckDBPyConnection, made_of: Sources, replaced: int) -> None:
    columns, stamps = json.dumps(dict(made_of.columns)), json.dumps(dict(made_of.stamps))
    row = [made_of.definitions, columns, stamps, replaced]
    connection.execute("INSERT INTO data.made_of VALUES (?, ?, ?, ?)", row)


def _put_in_place(ws: Workspace, temp: Path) -> None:
    with faults_of_the_system(ws.catalog):
        # left by someone who opened the old file for writing; DuckDB would replay it into the new one
        ws.catalog.with_name(f"{ws.catalog.name}.wal").unlink(missing_ok=True)
    replace_file(temp, ws.catalog)
    sync_folder(ws.root)


def _remove_database(temp: Path) -> None:
    temp.unlink(missing_ok=True)
    temp.with_name(f"{temp.name}.wal").unlink(missing_ok=True)
