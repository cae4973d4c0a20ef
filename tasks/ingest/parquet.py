"""Parquet with a record a point: columns x, y, z, or S, alpha, omega.

Memory is bounded by the (n, 3) result, one piece of records and one page a column. The result is allocated from the
count in the footer only after the pages of the three columns were found to hold it.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from storage.point_columns import (
    PointHeader,
    StoredColumn,
    check_point_pages,
    read_point_header,
    read_point_pieces,
)
from tasks.ingest.column_names import find_columns
from tasks.ingest.scan import Bounds, RawScan, Reader, ScanHeader, ScanRequest, box_of
from tasks.ingest.third_party import decoding


@dataclass(frozen=True, slots=True)
class _Checked:
    """The three columns of a file whose pages hold what its footer counts."""

    header: PointHeader
    columns: tuple[StoredColumn, ...]


def describe_parquet(path: Path, request: ScanRequest) -> ScanHeader:
    """What the footer of a Parquet file says, checked as far as that goes without decoding records."""
    with path.open("rb") as file:
        checked = _check(path, file, request)
    bounds = _stated_bounds(checked.columns) if request.coordinates == "cartesian" else None
    return ScanHeader("Parquet", checked.header.n_records, checked.header.size_bytes, bounds)


def read_parquet(path: Path, request: ScanRequest) -> RawScan:
    """All records of a Parquet file, as many as its footer states."""
    with path.open("rb") as file:
        checked = _check(path, file, request)
    values = np.empty((checked.header.n_records, 3))
    with decoding(path):
        _fill(path, checked, values)
    if request.coordinates == "polar":
        return RawScan(values)
    return RawScan(values, _step(checked.columns, values))


def _check(path: Path, file: BinaryIO, request: ScanRequest) -> _Checked:
    with decoding(path):
        header = read_point_header(path, file)
        places = find_columns(path, [column.name for column in header.columns], request.coordinates)
        columns = tuple(header.columns[place] for place in places)
        for column in columns:
            if not column.is_number:
                raise InputError(
                    f"{path}: needs numbers in column {column.name!r}, came {column.type_name[:60]}; "
                    "write it as double"
                )
        check_point_pages(path, file, header, columns)
    return _Checked(header, columns)


def _fill(path: Path, checked: _Checked, values: NDArray[np.float64]) -> None:
    """Decode all records into values (n, 3), piece by piece."""
    names = [column.name for column in checked.columns]
    done = n_incomplete = 0
    for piece in read_point_pieces(path, names):
        room = values[done : done + len(piece.values)]
        room[:] = piece.values[: len(room)]
        done, n_incomplete = done + len(piece.values), n_incomplete + piece.n_incomplete
    if done != len(values):
        raise InputError(
            f"{path}: needs the {len(values)} records that its footer states, came {done}; "
            "the file is damaged or being written, copy or export it again"
        )
    if n_incomplete:
        raise InputError(
            f"{path}: needs three coordinates a record, came {n_incomplete} of {len(values)} records with a null in "
            f"{', '.join(names)}; remove them, or export again without points that have no return"
        )


def _step(columns: tuple[StoredColumn, ...], values: NDArray[np.float64]) -> float:
    """Coarsest step in which the columns can hold the values (n, 3), in their unit; 0 for double precision."""
    box = box_of(values)
    farthest = np.maximum(np.abs(box.low), np.abs(box.high))
    # what is not finite has no step; the check for finite numbers then says so
    with np.errstate(invalid="ignore", over="ignore"):
        return max(column.step_at(float(far)) for column, far in zip(columns, farthest, strict=True))


def _stated_bounds(columns: tuple[StoredColumn, ...]) -> Bounds | None:
    lows = [column.low for column in columns if column.low is not None]
    highs = [column.high for column in columns if column.high is not None]
    if len(lows) < len(columns) or len(highs) < len(columns):
        return None
    return Bounds(np.array(lows), np.array(highs))


READER: Final = Reader("parquet", (".parquet", ".pq"), describe_parquet, read_parquet)
