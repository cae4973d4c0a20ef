"""What stands in a catalog: tables with the rows themselves, the views, and what every column means."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime
from typing import Final

import duckdb
import pyarrow as pa

from storage.arrow_columns import arrow_column
from storage.catalog_parts import CATALOG_TABLES, Part, key_columns, read_part
from storage.parquet import table_from_rows
from storage.records import columns_of
from storage.view_definitions import VIEWS, view_definition

_SQL_TYPES: Final = {bool: "BOOLEAN", int: "BIGINT", float: "DOUBLE", str: "VARCHAR", datetime: "TIMESTAMPTZ"}

READERS: Final = 4
"""Files that are read at once: thousands of small ones cost more of opening and decoding than of the disk."""

FILES_A_BATCH: Final = 64
"""Files whose rows are in memory together: a record of decades must not ask for more than a young one."""


def create_table(connection: duckdb.DuckDBPyConnection, table: str) -> None:
    """Make an empty table of the record class, in the schema ``data``."""
    fields = list(columns_of(CATALOG_TABLES[table]))
    columns = ", ".join(
        f"{field.name} {_SQL_TYPES[field.python_type]}{'' if field.nullable else ' NOT NULL'}"
        for field in fields
    )
    connection.execute(f"CREATE TABLE data.{table} ({columns})")
    for field in fields:
        _comment(connection, f"COLUMN data.{table}.{field.name}", _in_words(field.meaning, field.unit))


def copy_rows(connection: duckdb.DuckDBPyConnection, table: str, parts: Sequence[Part]) -> None:
    """Take over the rows of ``parts`` from the catalog attached as ``old``."""
    sql = (
        f"INSERT INTO data.{table} SELECT rows.* FROM old.data.{table} AS rows "  # noqa: S608 - names of our own
        f"SEMI JOIN incoming USING ({', '.join(key_columns(table))})"
    )
    _insert(connection, _keys(table, parts), sql)


def remove_rows(connection: duckdb.DuckDBPyConnection, table: str, parts: Sequence[Part]) -> None:
    """Remove the rows of ``parts`` from a table."""
    columns = key_columns(table)
    same = " AND ".join(f"data.{table}.{column} = incoming.{column}" for column in columns)
    _insert(connection, _keys(table, parts), f"DELETE FROM data.{table} USING incoming WHERE {same}")  # noqa: S608


def read_rows_in(connection: duckdb.DuckDBPyConnection, table: str, parts: Sequence[Part]) -> None:
    """Read the rows of files into a table.

    Raises
    ------
    StorageError
        If a file is damaged.
    """
    empty = table_from_rows(table, CATALOG_TABLES[table], [])
    with ThreadPoolExecutor(READERS) as pool:
        for start in range(0, len(parts), FILES_A_BATCH):
            batch = parts[start : start + FILES_A_BATCH]
            content = pa.concat_tables([empty, *pool.map(read_part, batch)])
            _insert(connection, content.combine_chunks(), f"INSERT INTO data.{table} SELECT * FROM incoming")  # noqa: S608 - as above
            if len(batch) == FILES_A_BATCH:  # what was registered is held until the transaction ends
                connection.execute("COMMIT")
                connection.execute("BEGIN")


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
    fields = [(view, field) for view, record in VIEWS.items() for field in columns_of(record)]
    columns = {
        "view": arrow_column([view for view, _ in fields], pa.string()),
        "name": arrow_column([field.name for _, field in fields], pa.string()),
        "unit": arrow_column([field.unit for _, field in fields], pa.string()),
        "meaning": arrow_column([field.meaning for _, field in fields], pa.string()),
        "nullable": arrow_column([field.nullable for _, field in fields], pa.bool_()),
    }
    _insert(connection, pa.table(columns), "INSERT INTO main.data_dictionary SELECT * FROM incoming")
    _comment(connection, "TABLE main.data_dictionary", "a row is a column of a view: its unit and meaning")


def _keys(table: str, parts: Sequence[Part]) -> pa.Table:
    columns = key_columns(table)
    values = zip(*(part.key for part in parts), strict=True) if parts else [()] * len(columns)
    return pa.table(
        {name: arrow_column(each, pa.string()) for name, each in zip(columns, values, strict=True)}
    )


def _insert(connection: duckdb.DuckDBPyConnection, incoming: pa.Table, sql: str) -> None:
    connection.register("incoming", incoming)
    connection.execute(sql)
    connection.unregister("incoming")


def _comment(connection: duckdb.DuckDBPyConnection, what: str, text: str) -> None:
    quoted = text.replace("'", "''")
    connection.execute(f"COMMENT ON {what} IS '{quoted}'")


def _in_words(meaning: str, unit: str) -> str:
    return f"{meaning} [{unit}]" if unit else meaning
