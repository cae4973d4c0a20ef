"""A view as a file that other programs read: CSV, Parquet or JSON, the same bytes for the same rows."""

import csv
import io
import json
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO, Final

import duckdb
import pyarrow as pa

from storage.catalog_reading import read_catalog
from storage.errors import StorageError, UsageError
from storage.named_files import write_named_file
from storage.parquet import Value, encode_table, python_values, schema_of
from storage.records import columns_of
from storage.view_definitions import VIEWS, view_definition
from storage.workspace import Workspace


def export_view(
    ws: Workspace, view: str, file_format: str, out: Path | BinaryIO, structure: str | None = None
) -> None:
    """Write the rows of a view, in the order of its columns from the left.

    Parameters
    ----------
    view : str
        Name of a view; those of the contract and pairs, coverage, surface_map, surface_changes, removals, schemes,
        latest.
    file_format : str
        ``csv`` (header, times in ISO 8601 UTC, NULL is empty), ``json`` (one array of objects) or ``parquet``.
    out : Path or binary file
        Where to; a file at a path appears whole or not at all.
    structure : str, optional
        Only the rows of this one; those of all where it is missing.

    Raises
    ------
    UsageError
        If there is no such view or format.
    StorageError
        If the catalog cannot be read or the file cannot be written.
    """
    view_definition(view)
    if file_format not in FORMATS:
        raise UsageError(f"unknown export format {file_format!r}; known: {', '.join(FORMATS)}")
    content = FORMATS[file_format](view, _content(ws, view, structure))
    if isinstance(out, Path):
        write_named_file(out, content)
    else:
        out.write(content)


def _content(ws: Workspace, view: str, structure: str | None) -> pa.Table:
    columns = ", ".join(field.name for field in columns_of(VIEWS[view]))
    where, params = ("", []) if structure is None else (" WHERE structure = ?", [structure])
    sql = f"SELECT {columns} FROM main.{view}{where} ORDER BY ALL"  # noqa: S608
    with read_catalog(ws) as connection:
        try:
            found = connection.sql(sql, params=params).to_arrow_table()
        except duckdb.Error as fault:
            raise StorageError(
                f"view {view} of {ws.catalog} cannot be read ({str(fault).splitlines()[0]}); delete the catalog "
                "and run again: it is rebuilt from the tables"
            ) from fault
    return found.cast(schema_of(view, VIEWS[view])).combine_chunks()


def _columns(view: str, content: pa.Table) -> dict[str, list[Value | None]]:
    return {field.name: list(python_values(content, field)) for field in columns_of(VIEWS[view])}


def _as_csv(view: str, content: pa.Table) -> bytes:
    columns = _columns(view, content)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_csv_cell(value) for value in row] for row in zip(*columns.values(), strict=True))
    return text.getvalue().encode()


def _as_json(view: str, content: pa.Table) -> bytes:
    columns = _columns(view, content)
    rows = [
        {name: _iso(value) for name, value in zip(columns, row, strict=True)}
        for row in zip(*columns.values(), strict=True)
    ]
    return json.dumps(rows, indent=1, allow_nan=False, ensure_ascii=False).encode() + b"\n"


def _as_parquet(_view: str, content: pa.Table) -> bytes:
    return encode_table(content)


FORMATS: Final[Mapping[str, Callable[[str, pa.Table], bytes]]] = {
    "csv": _as_csv,
    "json": _as_json,
    "parquet": _as_parquet,
}
"""What a view can be exported as."""


def _csv_cell(value: Value | None) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return str(_iso(value))


def _iso(value: Value | None) -> bool | int | float | str | None:
    if isinstance(value, datetime):
        return value.astimezone(UTC).isoformat().replace("+00:00", "Z")
    return value
