"""Rows to Parquet and back: types, units and meanings come from the record class."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import datetime
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import pyarrow as pa
import pyarrow.parquet as pq

from storage.arrow_columns import MICROSECOND, MICROSECONDS, START_OF_TIME, arrow_column
from storage.errors import StorageError
from storage.identity import SCHEMA_VERSION
from storage.records import Field, columns_of

Row = TypeVar("Row")
Value = bool | int | float | str | datetime

ARROW_TYPES: Final[Mapping[type, pa.DataType]] = {
    bool: pa.bool_(),
    int: pa.int64(),
    float: pa.float64(),
    str: pa.string(),
    datetime: MICROSECONDS,
}

_INT64: Final = range(-(2**63), 2**63)


def schema_of(table: str, record: type) -> pa.Schema:
    """Arrow schema of a record class; unit and meaning stand in the metadata of each field."""
    return _schema_of(table, record)


@cache
def _schema_of(table: str, record: type) -> pa.Schema:
    columns = [
        pa.field(
            field.name,
            ARROW_TYPES[field.python_type],
            nullable=field.nullable,
            metadata={"unit": field.unit, "meaning": field.meaning},
        )
        for field in columns_of(record)
    ]
    return pa.schema(columns, metadata={"table": table, "schema_version": str(SCHEMA_VERSION)})


def table_from_rows(table: str, record: type[Row], rows: Sequence[Row]) -> pa.Table:
    """Arrow table of rows, checked value by value.

    Raises
    ------
    StorageError
        If a row is of another class, or a value is of the wrong type, missing where it must not be, NaN or
        infinite; the message names table, column and row.
    """
    for number, row in enumerate(rows):
        if type(row) is not record:
            raise StorageError(
                f"table {table}, row {number}: needed a {record.__name__}, got a {type(row).__name__}"
            )
    schema = schema_of(table, record)
    columns = [_checked_column(table, field, rows) for field in columns_of(record)]
    arrays = [arrow_column(values, kind) for values, kind in zip(columns, schema.types, strict=True)]
    return pa.Table.from_arrays(arrays, schema=schema)


def rows_from_table(content: pa.Table, record: type[Row]) -> list[Row]:
    """Rows of a record class from a table that has its columns; times come back in UTC."""
    fields = list(columns_of(record))
    names = [field.name for field in fields]
    columns = [list(python_values(content, field)) for field in fields]
    return [record(**dict(zip(names, values, strict=True))) for values in zip(*columns, strict=True)]


def python_values(content: pa.Table, field: Field) -> Iterator[Value | None]:
    """Values of one column as Python has them; times in UTC."""
    stored = content.column(field.name)
    if field.python_type is not datetime:
        yield from stored.to_pylist()
        return
    # by hand, because pyarrow wants a time zone database for UTC, which Windows lacks
    for micros in stored.cast(MICROSECONDS).cast(pa.int64()).to_pylist():
        yield None if micros is None else START_OF_TIME + micros * MICROSECOND


def encode_rows(table: str, record: type[Row], rows: Sequence[Row]) -> bytes:
    """Parquet file of rows; equal rows give equal bytes under one version of pyarrow.

    Raises
    ------
    StorageError
        As ``table_from_rows``.
    """
    return encode_table(table_from_rows(table, record, rows))


def encode_table(content: pa.Table) -> bytes:
    """Parquet file of an Arrow table, with a checksum a page so that a flipped bit is seen on reading."""
    sink = pa.BufferOutputStream()
    pq.write_table(content, sink, compression="zstd", write_page_checksum=True)
    return bytes(sink.getvalue().to_pybytes())


def read_rows(path: Path, table: str, record: type[Row]) -> list[Row]:
    """Read a Parquet file as rows of a record class.

    Raises
    ------
    StorageError
        As ``read_table``.
    """
    return rows_from_table(read_table(path, table, record), record)


def read_table(path: Path, table: str, record: type) -> pa.Table:
    """Read a Parquet file under the schema of a record class.

    A column that an older file lacks reads as NULL where NULL is allowed; a column that the record class does
    not know is left out.

    Raises
    ------
    StorageError
        If the file is absent, damaged, of another table, of a newer version, or lacks a column that must be there.
    """
    content = _whole_content(path)
    _check_identity(path, table, content.schema.metadata or {})
    schema = schema_of(table, record)
    return pa.Table.from_arrays([_stored_column(path, content, column) for column in schema], schema=schema)


def stored_row_count(path: Path) -> int:
    """Rows of a Parquet file, as its footer says.

    Raises
    ------
    StorageError
        If the file is absent or damaged.
    """
    with _damage_told(path), pq.ParquetFile(path) as file:
        return int(file.metadata.num_rows)


def is_undamaged(path: Path) -> bool:
    """Whether every page of a Parquet file can be read and has its checksum, whatever its columns are."""
    try:
        _whole_content(path)
    except StorageError:
        return False
    return True


def _whole_content(path: Path) -> pa.Table:
    with _damage_told(path), pq.ParquetFile(path, page_checksum_verification=True) as file:
        # its own threads would wait for each other longer than a small file takes
        return file.read(use_threads=False)


@contextmanager
def _damage_told(path: Path) -> Iterator[None]:
    try:
        yield
    except FileNotFoundError as fault:
        raise StorageError(f"no table at {path}; run the epoch again to make it") from fault
    except (pa.ArrowException, OSError) as fault:
        first_line = str(fault).splitlines()[0]
        raise StorageError(
            f"{path} is damaged ({first_line}); delete it or restore it from a backup, and run the epoch again"
        ) from fault


def _check_identity(path: Path, table: str, metadata: Mapping[bytes, bytes]) -> None:
    stored = metadata.get(b"table", b"").decode(errors="replace")
    if stored != table:
        raise StorageError(f"{path} needs table {table!r} of tiltwatch; it holds {stored!r}")
    version = int(metadata.get(b"schema_version", b"0"))
    if version > SCHEMA_VERSION:
        raise StorageError(
            f"{path} has schema version {version}; this tiltwatch reads up to {SCHEMA_VERSION}: use a newer one"
        )


def _stored_column(path: Path, content: pa.Table, column: pa.Field) -> pa.ChunkedArray:
    if column.name not in content.column_names:
        if not column.nullable:
            raise StorageError(
                f"{path} lacks column {column.name}, which must have values; run the epoch again"
            )
        return pa.chunked_array([pa.nulls(content.num_rows, column.type)])
    stored = content.column(column.name)
    if stored.type != column.type:
        raise StorageError(f"{path}: column {column.name} needs {column.type}, it has {stored.type}")
    if stored.null_count and not column.nullable:
        raise StorageError(f"{path}: column {column.name} must have values, {stored.null_count} are NULL")
    return stored


def _checked_column(table: str, field: Field, rows: Sequence[object]) -> list[Value | None]:
    values = [getattr(row, field.name) for row in rows]
    if _are_plain(values, field):
        return values
    return [
        _checked(value, field, f"table {table}, column {field.name}, row {number}")
        for number, value in enumerate(values)
    ]


def _are_plain(values: Sequence[Any], field: Field) -> bool:
    """Whether a column needs no closer look: for a hundred thousand rows one value at a time takes seconds."""
    there = [value for value in values if value is not None]
    if (len(there) < len(values) and not field.nullable) or not set(map(type, there)) <= {field.python_type}:
        return False
    if field.python_type is float:
        return all(map(isfinite, there))
    if field.python_type is str:
        return all(map(str.isascii, there))
    return field.python_type is bool


def _checked(value: object, field: Field, where: str) -> Value | None:
    if value is None:
        if not field.nullable:
            raise StorageError(f"{where}: needed a value, got None; this column may not be NULL")
        return None
    if field.python_type is float and type(value) is int:
        value = float(value)
    # a bool is an int to Python, not to us
    if not isinstance(value, field.python_type) or isinstance(value, bool) is not (field.python_type is bool):
        raise StorageError(
            f"{where}: needed {field.python_type.__name__}, got {type(value).__name__} {value!r}"
        )
    known = cast("Value", value)
    fault = _fault_of(known)
    if fault:
        raise StorageError(f"{where}: {fault}")
    return known


def _fault_of(value: Value) -> str:
    if isinstance(value, float) and not isfinite(value):
        return f"got {value}; what does not exist is NULL (None), never NaN or infinite"
    if isinstance(value, int) and value not in _INT64:
        return f"got {value}, which is beyond 64 bits"
    if isinstance(value, datetime) and value.utcoffset() is None:
        return f"got {value.isoformat()}, which has no time zone; needed is an instant"
    if isinstance(value, str) and not _is_unicode(value):
        return f"got {value!r}, which is no valid Unicode text"
    return ""


def _is_unicode(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True
