"""Is the catalog what its tables make: quickly by counts, deeply by a new one that is made of the Parquet alone."""

import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Final

import duckdb

from storage.catalog import is_current, make_catalog
from storage.catalog_parts import CATALOG_TABLES
from storage.catalog_reading import opened_catalog, read_catalog
from storage.errors import StorageError
from storage.fault import Fault
from storage.parquet import stored_row_count
from storage.records import TABLES
from storage.tables import files_of
from storage.view_definitions import VIEWS
from storage.workspace import Workspace

AGAIN: Final = "delete the catalog and run the campaign again: it is rebuilt from the tables"

# what a catalog consists of beside its rows: columns with their types and comments, and views
_FORM: Final = (
    "SELECT schema_name, table_name, column_index, column_name, data_type, is_nullable, comment "
    "FROM duckdb_columns() WHERE database_name = ? AND NOT internal ORDER BY ALL",
    "SELECT schema_name, view_name, sql, comment FROM duckdb_views() WHERE database_name = ? AND NOT internal ORDER BY ALL",
)


def catalog_faults(ws: Workspace) -> Iterator[Fault | None]:
    """Whether the catalog is there, is made of the tables as they are, and shows as many rows."""
    if not ws.catalog.exists() and not any(files_of(ws, table) for table in TABLES):
        return
    if not is_current(ws):
        yield Fault(ws.catalog.name, "is absent, damaged or older than the tables", AGAIN)
    try:
        with read_catalog(ws) as connection:
            for table in TABLES:
                yield _count_fault(ws, connection, table)
            for view in VIEWS:
                connection.execute(f"SELECT count(*) FROM main.{view}").fetchone()  # noqa: S608
                yield None
    except (StorageError, duckdb.Error) as fault:
        yield Fault(ws.catalog.name, str(fault).splitlines()[0], AGAIN)


def _count_fault(ws: Workspace, connection: duckdb.DuckDBPyConnection, table: str) -> Fault | None:
    row = connection.execute(f"SELECT count(*) FROM data.{table}").fetchone()  # noqa: S608 - names of our own
    shown = None if row is None else row[0]
    stored = sum(stored_row_count(path) for path in files_of(ws, table))
    if shown == stored:
        return None
    what = f"shows {shown} rows of {table}; the tables hold {stored}"
    return Fault(ws.catalog.name, what, AGAIN)


def deep_catalog_faults(ws: Workspace) -> Iterator[Fault | None]:
    """The same, and whether every table, view, type and comment is as in a catalog that is made of the tables anew."""
    shallow = list(catalog_faults(ws))
    yield from shallow
    if not shallow or any(fault is not None for fault in shallow):
        return
    try:
        with tempfile.TemporaryDirectory() as folder:
            fresh = Path(folder) / "fresh.duckdb"
            make_catalog(ws, fresh)
            yield _difference(ws, fresh)
    except (StorageError, duckdb.Error) as fault:
        yield Fault(ws.catalog.name, str(fault).splitlines()[0], AGAIN)


def _difference(ws: Workspace, fresh: Path) -> Fault | None:
    with closing(opened_catalog(ws.catalog, fresh)) as connection:
        for query in _FORM:
            of_old, of_new = (connection.execute(query, [name]).fetchall() for name in ("catalog", "fresh"))
            if of_old != of_new:
                return Fault(
                    ws.catalog.name, "its columns, views or comments are not those of the tables", AGAIN
                )
        for table in (*(f"data.{name}" for name in CATALOG_TABLES), "main.data_dictionary"):
            if _n_other_rows(connection, table):
                return Fault(ws.catalog.name, f"shows other rows of {table} than the tables hold", AGAIN)
    return None


def _n_other_rows(connection: duckdb.DuckDBPyConnection, table: str) -> int:
    """Rows that stand in one of the two catalogs only."""
    one, other = f"SELECT * FROM catalog.{table}", f"SELECT * FROM fresh.{table}"  # noqa: S608 - names of our own
    both = f"({one} EXCEPT ALL {other}) UNION ALL ({other} EXCEPT ALL {one})"
    row = connection.execute(f"SELECT count(*) FROM ({both})").fetchone()  # noqa: S608 - as above
    return 0 if row is None else int(row[0])
