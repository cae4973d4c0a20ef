"""What stands in a catalog: tables with the rows themselves, the views, and what every column means."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Final

import duckdb
import pyarrow as pa

from storage.parquet import read_table, schema_of
from storage.records import TABLES, columns_of
from storage.tables import key_of, part_column
from storage.view_definitions import VIEWS, view_definition

_SQL_TYPES: Final = {bool: "BOOLEAN", int: "BIGINT", float: "DOUBLE", str: "VARCHAR", datetime: "TIMESTAMPTZ"}


def create_table(connection: duckdb.DuckDBPyConnection, table: str) -> None:
    """Make an empty table of the record class, in the schema ``data``."""
    fields = list(columns_of(TABLES[table]))
    columns = ", ".join(
        f"{field.name} {_SQL_TYPES[field.python_type]}{'' if field.nullable else ' NOT NULL'}"
        for field in fields
    )
    connection.execute(f"CREATE TABLE data.{table} ({columns})")
    for field in fields:
        _comment(connection, f"COLUMN data.{table}.{field.name}", _in_words(field.meaning, field.unit))


def copy_rows(connection: duckdb.DuckDBPyConnection, table: str, files: Sequence[Path]) -> None:
    """Take over the rows that came from ``files`` from the catalog attached as ``old``."""
    keys = [key_of(path) for path in files]
    part = part_column(table)
    same_part = "" if part is None else f" AND rows.{part} = incoming.part"
    wanted = pa.table(
        {"structure": [key.structure for key in keys], "part": [key.epoch for key in keys]},
        schema=pa.schema({"structure": pa.string(), "part": pa.string()}),
    )
    _insert(
        connection,
        wanted,
        f"INSERT INTO data.{table} SELECT rows.* FROM old.data.{table} AS rows "  # noqa: S608 - names of our own
        f"SEMI JOIN incoming ON rows.structure = incoming.structure{same_part}",
    )


def read_rows_in(connection: duckdb.DuckDBPyConnection, table: str, files: Sequence[Path]) -> None:
    """Read the rows of Parquet files into a table.

    Raises
    ------
    StorageError
        If a file is damaged.
    """
    record = TABLES[table]
    parts = [read_table(path, table, record) for path in files]
    content = pa.concat_tables([schema_of(table, record).empty_table(), *parts])
    _insert(connection, content, f"INSERT INTO data.{table} SELECT * FROM incoming")  # noqa: S608 - as above


def create_view(connection: duckdb.DuckDBPyConnection, view: str) -> None:
    """Make a view of the contract, with a comment on it and on each column."""
    definition = view_definition(view)
    connection.execute(f"CREATE VIEW main.{view} AS {definition.sql}")
    _comment(connection, f"VIEW main.{view}", f"a row is {definition.row_is}")
    for field in columns_of(VIEWS[view]):
        _comment(connection, f"COLUMN main.{view}.{field.name}", _in_words(field.meaning, field.unit))


def fill_dictionary(connection: duckdb.DuckDBPyConnection) -> None:
    """Make the table that says unit and meaning of every column of every view."""
    connection.execute(
        "CREATE TABLE main.data_dictionary (table_name VARCHAR NOT NULL, column_name VARCHAR NOT NULL, "
        "unit VARCHAR NOT NULL, meaning VARCHAR NOT NULL, nullable BOOLEAN NOT NULL)"
    )
    rows = [
        {
            "view": view,
            "name": field.name,
            "unit": field.unit,
            "meaning": field.meaning,
            "nullable": field.nullable,
        }
        for view, record in VIEWS.items()
        for field in columns_of(record)
    ]
    _insert(connection, pa.Table.from_pylist(rows), "INSERT INTO main.data_dictionary SELECT * FROM incoming")
    _comment(connection, "TABLE main.data_dictionary", "a row is a column of a view: its unit and meaning")


def _insert(connection: duckdb.DuckDBPyConnection, incoming: pa.Table, sql: str) -> None:
    connection.register("incoming", incoming)
    connection.execute(sql)
    connection.unregister("incoming")


def _comment(connection: duckdb.DuckDBPyConnection, what: str, text: str) -> None:
    quoted = text.replace("'", "''")
    connection.execute(f"COMMENT ON {what} IS '{quoted}'")


def _in_words(meaning: str, unit: str) -> str:
    return f"{meaning} [{unit}]" if unit else meaning
