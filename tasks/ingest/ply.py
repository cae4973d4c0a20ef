"""PLY as text and binary, little and big endian: the element "vertex", whatever stands before and after it.

All elements are followed to the end of the file, so that a file that was cut is refused even if its points are whole.
"""

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
from tasks.ingest.ply_header import PlyElement, PlyHeader, read_ply_header
from tasks.ingest.ply_lists import gather, locate_records
from tasks.ingest.ply_text import read_ply_text
from tasks.ingest.scan import RawScan, Reader, ScanHeader, ScanRequest
from tasks.ingest.scan_parts import choose_parts

KINDS: Final = {"": "text", "<": "binary", ">": "binary, big endian"}
SLACK_BYTES: Final = 2
"""Behind the last record: a line end that a transfer may have put there. More is data that the header does not state."""


def describe_ply(path: Path, request: ScanRequest) -> ScanHeader:
    """What the header of a PLY file says, checked against the size of the file where no lists are in the way."""
    choose_parts(path, [None], request)
    with path.open("rb") as file:
        header = read_ply_header(path, file)
        columns = _columns(path, header, request)
        size_bytes = size_of(file)
    vertex = header.elements[header.vertex]
    if header.byte_order and not any(element.has_lists for element in header.elements[: header.vertex + 1]):
        before = sum(element.count * element.least_bytes for element in header.elements[: header.vertex])
        check_room(path, size_bytes, _fixed(vertex, columns, header.body_at + before))
    return ScanHeader(f"PLY 1.0 ({KINDS[header.byte_order]})", vertex.count, size_bytes, None)


def read_ply(path: Path, request: ScanRequest) -> RawScan:
    """All vertices of a PLY file."""
    choose_parts(path, [None], request)
    with path.open("rb") as file:
        header = read_ply_header(path, file)
        columns = _columns(path, header, request)
        # text holds the digits that stand in it, whatever the header says of its types: no step is known
        raw = (_read_binary if header.byte_order else read_ply_text)(path, file, header, columns)
    return RawScan(raw.values, raw.step, zero_missing(path, raw.values) + raw.notes)


def _columns(path: Path, header: PlyHeader, request: ScanRequest) -> tuple[int, int, int]:
    properties = header.elements[header.vertex].properties
    columns = find_columns(path, [known.name for known in properties], request.coordinates)
    if any(properties[column].length_type is not None for column in columns):
        raise InputError(f"{path}: needs a number for each coordinate, came a list; export the scan again")
    return columns


def _read_binary(path: Path, file: BinaryIO, header: PlyHeader, columns: tuple[int, int, int]) -> RawScan:
    # mapped, not read: pages come and go as they are needed
    content = np.asarray(np.memmap(path, np.uint8, "r"))
    vertex = header.elements[header.vertex]
    at = header.body_at
    for element in header.elements[: header.vertex]:
        at = locate_records(path, content, at, element, ()).end
    if vertex.has_lists:
        located = locate_records(path, content, at, vertex, columns)
        types = [vertex.properties[column].type for column in columns]
        values = np.column_stack(
            [
                gather(content, offsets, number_type)
                for offsets, number_type in zip(located.offsets.T, types, strict=True)
            ]
        )
        at = located.end
    else:
        records = _fixed(vertex, columns, at)
        values, at = read_records(path, file, records), records.end
    for element in header.elements[header.vertex + 1 :]:
        at = locate_records(path, content, at, element, ()).end
    if len(content) - at > SLACK_BYTES or not is_slack(content[at:].tobytes()):
        raise InputError(
            f"{path}: needs no more than its header states, came {len(content) - at} bytes behind the last record; "
            "the count is wrong, export again"
        )
    return RawScan(values, storage_step([vertex.properties[column].type for column in columns], values))


def _fixed(vertex: PlyElement, columns: tuple[int, int, int], at: int) -> FixedRecords:
    """Vertices without lists, from byte ``at`` on."""
    widths = [np.dtype(known.type).itemsize for known in vertex.properties]
    x, y, z = columns
    return FixedRecords(
        vertex.count,
        (vertex.properties[x].type, vertex.properties[y].type, vertex.properties[z].type),
        (sum(widths[:x]), sum(widths[:y]), sum(widths[:z])),
        sum(widths),
        at,
    )


READER: Final = Reader("ply", (".ply",), describe_ply, read_ply)
