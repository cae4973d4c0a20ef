"""PCD 0.6 and 0.7 of the Point Cloud Library: text, binary, and compressed binary.

VIEWPOINT other than the identity is the pose of the scanner. Programs differ in what it says of the points: PCL's
documents have them in the frame of the viewpoint's coordinates, its viewer, its pcl_transform_from_viewpoint and
CloudCompare have them in the scanner's frame. A station's points are taken as they stand, as in the scanner's frame,
with a note; a cloud in the frame of the file is refused.
"""

import struct
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from storage.errors import InputError
from tasks.ingest.binary_records import (
    FixedRecords,
    check_room,
    is_slack,
    read_records,
    size_of,
    storage_step,
    zero_missing,
)
from tasks.ingest.column_names import find_columns
from tasks.ingest.lzf import decompress_lzf
from tasks.ingest.pcd_header import PcdHeader, read_pcd_header
from tasks.ingest.scan import RawScan, Reader, ScanHeader, ScanRequest
from tasks.ingest.scan_parts import choose_parts
from tasks.ingest.text_rows import CountedRows, end_notes, next_line, read_rows, refuse_rest, separator_of

SLACK_BYTES: Final = 2
"""Behind the last point: a line end that a transfer may have put there. More is data that the header does not state."""

SIZES_BYTES: Final = 8
"""Packed and unpacked size before compressed points."""

STATED_BY: Final = "its header"

VIEWPOINT_NOTE: Final = (
    "VIEWPOINT is taken as the scanner's pose, and the points as in its own frame; programs differ in that"
)


def describe_pcd(path: Path, request: ScanRequest) -> ScanHeader:
    """What the header of a PCD file says, checked against the size of the file."""
    with path.open("rb") as file:
        header = _checked_header(path, file, request)
        columns = _columns(path, header, request)
        size_bytes = size_of(file)
    if header.encoding == "binary":
        check_room(path, size_bytes, _fixed(header, columns))
    return ScanHeader(f"PCD 0.{header.version[-1]} ({header.encoding})", header.n_points, size_bytes, None)


def read_pcd(path: Path, request: ScanRequest) -> RawScan:
    """All points of a PCD file."""
    with path.open("rb") as file:
        header = _checked_header(path, file, request)
        read = {"ascii": _read_text, "binary": _read_binary, "binary_compressed": _read_compressed}
        raw = read[header.encoding](path, file, header, _columns(path, header, request))
    notes = raw.notes + zero_missing(path, raw.values)
    if header.viewpoint is not None:
        notes += (VIEWPOINT_NOTE,)
    return RawScan(raw.values, raw.step, notes, header.viewpoint)


def _checked_header(path: Path, file: BinaryIO, request: ScanRequest) -> PcdHeader:
    choose_parts(path, [None], request)
    header = read_pcd_header(path, file)
    if request.frame == "file" and header.viewpoint is not None:
        raise InputError(
            f"{path}: needs points in one stated frame, came a VIEWPOINT other than 0 0 0 1 0 0 0, of which programs "
            "differ whether it is still to be applied; place the points and export again with that VIEWPOINT, or as LAZ"
        )
    return header


def _columns(path: Path, header: PcdHeader, request: ScanRequest) -> tuple[int, int, int]:
    columns = find_columns(path, [field.name for field in header.fields], request.coordinates)
    if any(header.fields[column].count != 1 for column in columns):
        raise InputError(f"{path}: needs COUNT 1 for each coordinate, came more; export the scan again")
    return columns


def _types(header: PcdHeader, columns: tuple[int, int, int]) -> tuple[str, str, str]:
    x, y, z = (header.fields[column].type for column in columns)
    return x, y, z


def _read_text(path: Path, file: BinaryIO, header: PcdHeader, columns: tuple[int, int, int]) -> RawScan:
    separator = separator_of(next_line(path, file) or "")
    file.seek(header.body_at)
    counts = [field.count for field in header.fields]
    x, y, z = (sum(counts[:column]) for column in columns)
    rows = CountedRows(header.n_points, sum(counts), (x, y, z), separator, header.first_line, STATED_BY)
    values = read_rows(path, file, rows)
    refuse_rest(path, file, STATED_BY, header.first_line + header.n_points)
    # text holds the digits that stand in it, whatever the header says of its types: no step is known
    return RawScan(values, notes=end_notes(file, rows))


def _read_binary(path: Path, file: BinaryIO, header: PcdHeader, columns: tuple[int, int, int]) -> RawScan:
    records = _fixed(header, columns)
    values = read_records(path, file, records)
    n_over = size_of(file) - records.end
    file.seek(records.end)
    if n_over > SLACK_BYTES or not is_slack(file.read(SLACK_BYTES)):
        raise InputError(
            f"{path}: needs no more than the {header.n_points} points that its header states, came {n_over} bytes "
            "behind them; the count is wrong, export again"
        )
    return RawScan(values, storage_step(records.types, values))


def _read_compressed(path: Path, file: BinaryIO, header: PcdHeader, columns: tuple[int, int, int]) -> RawScan:
    """All fields of all points one after the other: x of all, y of all, ..."""
    content = _unpacked(path, file, header)
    values = np.empty((header.n_points, 3))
    for place, column in enumerate(columns):
        start = header.n_points * sum(field.width for field in header.fields[:column])
        values[:, place] = np.frombuffer(content, header.fields[column].type, header.n_points, start)
    return RawScan(values, storage_step(_types(header, columns), values))


def _unpacked(path: Path, file: BinaryIO, header: PcdHeader) -> bytearray:
    n_rest = size_of(file) - header.body_at
    file.seek(header.body_at)
    sizes = file.read(SIZES_BYTES)
    n_packed, n_unpacked = struct.unpack("<II", sizes) if len(sizes) == SIZES_BYTES else (0, 0)
    if n_unpacked != header.n_points * header.record_bytes:
        raise InputError(
            f"{path}: needs the {header.n_points} points of {header.record_bytes} bytes that its header states, came "
            f"{n_unpacked} bytes of them; the file is cut short or damaged, export it again"
        )
    if n_packed > n_rest - SIZES_BYTES:
        raise InputError(
            f"{path}: needs {n_packed} bytes of compressed points, came {n_rest - SIZES_BYTES}; "
            "the file is cut short, copy or export it again"
        )
    try:
        return decompress_lzf(file.read(n_packed), n_unpacked)
    except InputError as error:
        raise InputError(
            f"{path}: needs {header.n_points} points, came {error}; the file is damaged, export it again"
        ) from error


def _fixed(header: PcdHeader, columns: tuple[int, int, int]) -> FixedRecords:
    widths = [field.width for field in header.fields]
    x, y, z = (sum(widths[:column]) for column in columns)
    return FixedRecords(
        header.n_points, _types(header, columns), (x, y, z), header.record_bytes, header.body_at
    )


READER: Final = Reader("pcd", (".pcd",), describe_pcd, read_pcd)
