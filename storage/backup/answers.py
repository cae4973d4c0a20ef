"""What a catalog answers, as digests: whether a restored workspace says the same as the one that was archived."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import duckdb
import pyarrow as pa
import pyarrow.csv

from storage.catalog_reading import read_catalog
from storage.catalog_sources import catalog_definitions
from storage.errors import StorageError
from storage.records import columns_of
from storage.view_definitions import VIEWS
from storage.workspace import Workspace

ROWS_AT_ONCE: Final = 100_000


@dataclass(frozen=True, slots=True)
class Answer:
    """Rows of a view, and the SHA-256 of their values in the order of all columns."""

    rows: int
    sha256: str


@dataclass(frozen=True, slots=True)
class Answers:
    """What every view of a catalog answers."""

    definitions: str
    """Digest of views, columns and DuckDB: answers of other definitions need not be the same."""
    views: Mapping[str, Answer]


def answers_of(ws: Workspace) -> Answers:
    """Ask every view of the catalog for all its rows.

    Raises
    ------
    StorageError
        If the catalog is absent or cannot be read.
    """
    with read_catalog(ws) as connection:
        try:
            return Answers(catalog_definitions(), {view: _answer(connection, view) for view in VIEWS})
        except duckdb.Error as fault:
            raise StorageError(
                f"{ws.catalog} cannot be read ({str(fault).splitlines()[0]}); delete it and run again: it is rebuilt "
                "from the tables"
            ) from fault


def _answer(connection: duckdb.DuckDBPyConnection, view: str) -> Answer:
    columns = ", ".join(field.name for field in columns_of(VIEWS[view]))
    sql = f"SELECT {columns} FROM main.{view} ORDER BY ALL"  # noqa: S608 (names of our own)
    digest, rows = _Digest(), 0
    # text of shortest floats is the same on every machine, and a NULL differs from an empty text
    options = pyarrow.csv.WriteOptions(quoting_style="all_valid")
    for batch in connection.sql(sql).to_arrow_reader(ROWS_AT_ONCE):
        plain = pa.table({name: _plain(batch.column(name)) for name in batch.schema.names})
        with pa.PythonFile(digest, mode="w") as sink:
            pyarrow.csv.write_csv(plain, sink, options)
        rows += batch.num_rows
    return Answer(rows, digest.sha.hexdigest())


def _plain(column: pa.Array) -> pa.Array:
    """Times as microseconds since 1970: their text needs a time zone database."""
    return column.cast(pa.int64()) if pa.types.is_timestamp(column.type) else column


class _Digest:
    """A file that is only hashed."""

    closed = False

    def __init__(self) -> None:
        self.sha = hashlib.sha256()

    def write(self, content: bytes) -> int:
        self.sha.update(content)
        return len(content)

    def writable(self) -> bool:
        return True

    def readable(self) -> bool:
        return False

    def seekable(self) -> bool:
        return False

    def flush(self) -> None:
        """Nothing is held back."""

    def close(self) -> None:
        """The next batch goes on."""
