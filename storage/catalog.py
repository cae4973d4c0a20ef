"""The catalog: one DuckDB file that holds all rows and the views of the contract, made anew from the Parquet."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import duckdb

from storage.atomic import faults_of_the_system, replace_file, sync_file, sync_folder, temp_beside
from storage.catalog_content import copy_rows, create_table, create_view, fill_dictionary, read_rows_in
from storage.errors import StorageError
from storage.locks import publish_lock
from storage.publish import recover
from storage.records import TABLES, columns_of
from storage.tables import files_of
from storage.verified import stamp_of
from storage.view_definitions import VIEWS, view_definition
from storage.workspace import Workspace

# a file of DuckDB 2's own default is refused by every 1.x client
STORAGE_VERSION: Final = "v1.0.0"


@dataclass(frozen=True, slots=True)
class Sources:
    """All that a catalog is made of."""

    definitions: str
    """Digest of the views, the columns and the version of DuckDB."""
    stamps: Mapping[str, str]
    """Parquet file, relative to the tables, to its inode, size and time of change."""


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
        old, new = _stored_sources(ws), _sources(ws)
        if old == new:
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
    return _stored_sources(ws) == _sources(ws)


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
    connection = duckdb.connect()
    try:
        _attach(connection, ws.catalog, "catalog", "READ_ONLY")
        connection.execute("USE catalog")
        connection.execute("SET TimeZone = 'UTC'")
        yield connection
    finally:
        connection.close()


def _sources(ws: Workspace) -> Sources:
    sql = {name: view_definition(name).sql for name in VIEWS}
    columns = {name: repr(list(columns_of(record))) for name, record in VIEWS.items()}
    text = json.dumps([sql, columns, duckdb.__version__], sort_keys=True)
    stamps = {
        path.relative_to(ws.tables).as_posix(): str(stamp_of(path))
        for table in TABLES
        for path in files_of(ws, table)
    }
    return Sources(hashlib.sha256(text.encode()).hexdigest(), stamps)


def _stored_sources(ws: Workspace) -> Sources | None:
    """What the present catalog was made of; None if there is no catalog that can be read."""
    try:
        with read_catalog(ws) as connection:
            row = connection.execute("SELECT definitions, stamps FROM data.made_of").fetchone()
    except (StorageError, duckdb.Error):
        return None
    return None if row is None else Sources(row[0], json.loads(row[1]))


def _attach(connection: duckdb.DuckDBPyConnection, path: Path, name: str, option: str) -> None:
    quoted = str(path).replace("'", "''")
    try:
        connection.execute(f"ATTACH '{quoted}' AS {name} ({option})")
    except duckdb.Error as fault:
        raise StorageError(
            f"cannot open {path}: {str(fault).splitlines()[0]}; close the program that writes to it, or delete it "
            "and run again: it is rebuilt from the tables"
        ) from fault


def _build(ws: Workspace, temp: Path, old: Sources | None, new: Sources) -> None:
    connection = duckdb.connect()
    try:
        _attach(connection, temp, "catalog", f"STORAGE_VERSION '{STORAGE_VERSION}'")
        if old is not None:
            _attach(connection, ws.catalog, "old", "READ_ONLY")
        connection.execute("USE catalog")
        connection.execute("BEGIN")  # else each of some hundred comments is brought to the disk by itself
        connection.execute("CREATE SCHEMA data")
        for table in TABLES:
            _fill_table(connection, ws, table, _unchanged(old, new))
        for view in VIEWS:
            create_view(connection, view)
        fill_dictionary(connection)
        connection.execute("CREATE TABLE data.made_of (definitions VARCHAR, stamps VARCHAR)")
        stamps = json.dumps(dict(new.stamps))
        connection.execute("INSERT INTO data.made_of VALUES (?, ?)", [new.definitions, stamps])
        connection.execute("COMMIT")
        connection.execute("USE memory")
        connection.execute("DETACH catalog")  # writes everything into the one file
    finally:
        connection.close()


def _unchanged(old: Sources | None, new: Sources) -> frozenset[str]:
    """The files whose rows the old catalog holds as they are."""
    if old is None or old.definitions != new.definitions:
        return frozenset()
    return frozenset(file for file, stamp in new.stamps.items() if old.stamps.get(file) == stamp)


def _fill_table(
    connection: duckdb.DuckDBPyConnection, ws: Workspace, table: str, unchanged: frozenset[str]
) -> None:
    create_table(connection, table)
    files = files_of(ws, table)
    known = {path for path in files if path.relative_to(ws.tables).as_posix() in unchanged}
    if known:
        copy_rows(connection, table, sorted(known))
    read_rows_in(connection, table, [path for path in files if path not in known])


def _put_in_place(ws: Workspace, temp: Path) -> None:
    with faults_of_the_system(ws.catalog):
        # left by someone who opened the old file for writing; DuckDB would replay it into the new one
        ws.catalog.with_name(f"{ws.catalog.name}.wal").unlink(missing_ok=True)
    replace_file(temp, ws.catalog)
    sync_folder(ws.root)


def _remove_database(temp: Path) -> None:
    temp.unlink(missing_ok=True)
    temp.with_name(f"{temp.name}.wal").unlink(missing_ok=True)
