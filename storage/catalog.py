"""The catalog: one DuckDB file that holds all rows and the views of the contract, made anew from the Parquet."""

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Final

import duckdb
import pyarrow as pa

from storage.atomic import faults_of_the_system, replace_file, sync_file, sync_folder, temp_beside
from storage.errors import StorageError
from storage.locks import publish_lock
from storage.parquet import read_table, schema_of
from storage.publish import recover
from storage.records import TABLES, columns_of
from storage.tables import files_of
from storage.verified import stamp_of
from storage.view_definitions import VIEWS, view_definition
from storage.workspace import Workspace

# a file of DuckDB 2's own default is refused by every 1.x client
STORAGE_VERSION: Final = "v1.0.0"

_SQL_TYPES: Final = {bool: "BOOLEAN", int: "BIGINT", float: "DOUBLE", str: "VARCHAR", datetime: "TIMESTAMPTZ"}


def rebuild_catalog(ws: Workspace) -> bool:
    """Make the catalog anew from the tables and put it in place at once; readers keep what they have open.

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
        fingerprint = fingerprint_of(ws)
        if stored_fingerprint(ws) == fingerprint:
            return False
        temp = temp_beside(ws.tmp / ws.catalog.name)
        try:
            _build(ws, temp, fingerprint)
            sync_file(temp)
            _put_in_place(ws, temp)
        finally:
            _remove_database(temp)
    return True


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
        _attach(connection, ws.catalog, "READ_ONLY")
        connection.execute("SET TimeZone = 'UTC'")
        yield connection
    finally:
        connection.close()


def fingerprint_of(ws: Workspace) -> str:
    """Digest of all that the catalog is made of: the files by name, size and time, the views, the columns."""
    stamps = {}
    for table in TABLES:
        for path in files_of(ws, table):
            stamp = stamp_of(path)
            stamps[path.relative_to(ws.tables).as_posix()] = None if stamp is None else asdict(stamp)
    sql = {name: view_definition(name).sql for name in VIEWS}
    columns = {name: repr(list(columns_of(record))) for name, record in VIEWS.items()}
    text = json.dumps([stamps, sql, columns, duckdb.__version__], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def stored_fingerprint(ws: Workspace) -> str | None:
    """Fingerprint of what the present catalog was made of; None if there is no catalog that can be read."""
    try:
        with read_catalog(ws) as connection:
            row = connection.execute("SELECT fingerprint FROM data.made_of").fetchone()
    except (StorageError, duckdb.Error):
        return None
    return None if row is None else str(row[0])


def rows_in_tables(ws: Workspace, table: str) -> pa.Table:
    """All rows of a table, from its Parquet files, in the order of structure and epoch."""
    record = TABLES[table]
    parts = [read_table(path, table, record) for path in files_of(ws, table)]
    return pa.concat_tables(parts) if parts else schema_of(table, record).empty_table()


def _attach(connection: duckdb.DuckDBPyConnection, path: Path, option: str) -> None:
    quoted = str(path).replace("'", "''")
    try:
        connection.execute(f"ATTACH '{quoted}' AS catalog ({option})")
        connection.execute("USE catalog")
    except duckdb.Error as fault:
        raise StorageError(
            f"cannot open {path}: {str(fault).splitlines()[0]}; close the program that writes to it, or delete it "
            "and run again: it is rebuilt from the tables"
        ) from fault


def _build(ws: Workspace, temp: Path, fingerprint: str) -> None:
    connection = duckdb.connect()
    try:
        _attach(connection, temp, f"STORAGE_VERSION '{STORAGE_VERSION}'")
        connection.execute("BEGIN")  # else each of some hundred comments is brought to the disk by itself
        connection.execute("CREATE SCHEMA data")
        for table in TABLES:
            _fill_table(connection, ws, table)
        for view in VIEWS:
            _create_view(connection, view)
        _fill_dictionary(connection)
        connection.execute("CREATE TABLE data.made_of AS SELECT ?::VARCHAR AS fingerprint", [fingerprint])
        connection.execute("COMMIT")
        connection.execute("USE memory")
        connection.execute("DETACH catalog")  # writes everything into the one file
    finally:
        connection.close()


def _fill_table(connection: duckdb.DuckDBPyConnection, ws: Workspace, table: str) -> None:
    columns = ", ".join(
        f"{field.name} {_SQL_TYPES[field.python_type]}{'' if field.nullable else ' NOT NULL'}"
        for field in columns_of(TABLES[table])
    )
    connection.execute(f"CREATE TABLE data.{table} ({columns})")
    connection.register("incoming", rows_in_tables(ws, table))
    connection.execute(f"INSERT INTO data.{table} SELECT * FROM incoming")  # noqa: S608 - names of our own
    connection.unregister("incoming")
    for field in columns_of(TABLES[table]):
        _comment(connection, f"COLUMN data.{table}.{field.name}", _in_words(field.meaning, field.unit))


def _create_view(connection: duckdb.DuckDBPyConnection, view: str) -> None:
    definition = view_definition(view)
    connection.execute(f"CREATE VIEW main.{view} AS {definition.sql}")
    _comment(connection, f"VIEW main.{view}", f"a row is {definition.row_is}")
    for field in columns_of(VIEWS[view]):
        _comment(connection, f"COLUMN main.{view}.{field.name}", _in_words(field.meaning, field.unit))


def _comment(connection: duckdb.DuckDBPyConnection, what: str, text: str) -> None:
    quoted = text.replace("'", "''")
    connection.execute(f"COMMENT ON {what} IS '{quoted}'")


def _in_words(meaning: str, unit: str) -> str:
    return f"{meaning} [{unit}]" if unit else meaning


def _fill_dictionary(connection: duckdb.DuckDBPyConnection) -> None:
    connection.execute(
        "CREATE TABLE main.data_dictionary (table_name VARCHAR NOT NULL, column_name VARCHAR NOT NULL, "
        "unit VARCHAR NOT NULL, meaning VARCHAR NOT NULL, nullable BOOLEAN NOT NULL)"
    )
    rows = [
        (view, field.name, field.unit, field.meaning, field.nullable)
        for view, record in VIEWS.items()
        for field in columns_of(record)
    ]
    connection.executemany("INSERT INTO main.data_dictionary VALUES (?, ?, ?, ?, ?)", rows)
    _comment(connection, "TABLE main.data_dictionary", "a row is a column of a view: its unit and meaning")


def _put_in_place(ws: Workspace, temp: Path) -> None:
    with faults_of_the_system(ws.catalog):
        # left by someone who opened the old file for writing; DuckDB would replay it into the new one
        ws.catalog.with_name(f"{ws.catalog.name}.wal").unlink(missing_ok=True)
    replace_file(temp, ws.catalog)
    sync_folder(ws.root)


def _remove_database(temp: Path) -> None:
    temp.unlink(missing_ok=True)
    temp.with_name(f"{temp.name}.wal").unlink(missing_ok=True)
