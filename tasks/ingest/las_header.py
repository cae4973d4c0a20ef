"""The header of a LAS or LAZ file, read and checked before any library believes it.

The libraries trust it: a header that claims 1e9 variable length records keeps them busy for minutes, and a file
that was cut short gives them fewer points and a line in a log.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError

SIGNATURE: Final = b"LASF"
LONGEST_HEADER: Final = 375
HEADER_BYTES: Final[Mapping[int, int]] = MappingProxyType({0: 227, 1: 227, 2: 227, 3: 235, 4: LONGEST_HEADER})
"""Size of the header by minor version."""

RECORD_BYTES: Final = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)
"""Size of a point record by point format, without extra bytes."""

COMPRESSED_BIT: Final = 0x80
"""Set in the point format of a LAZ file."""


@dataclass(frozen=True, slots=True)
class LasHeader:
    """The fields of a header that reading needs; offsets are bytes from the start of the file.

    ``n_by_return`` are the first, second, ... returns that it counts; those without a number are not among them.
    """

    minor: int
    header_bytes: int
    points_at: int
    n_records: int
    point_format: int
    is_compressed: bool
    record_bytes: int
    n_points: int
    n_by_return: int
    scale: NDArray[np.float64]
    shift: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    waveforms_at: int
    n_late_records: int
    late_records_at: int
    size_bytes: int


def read_las_header(path: Path, file: BinaryIO) -> LasHeader:
    """Header of a LAS or LAZ file, consistent in itself and with the size of the file.

    Raises
    ------
    InputError
        If it is not; of a LAS file also if the count of points disagrees with the size.
    """
    size_bytes = file.seek(0, 2)
    file.seek(0)
    head = file.read(LONGEST_HEADER)
    if head[:4] != SIGNATURE:
        raise InputError(
            f"{path}: needs a LAS or LAZ file, which begins with 'LASF', came "
            f"{'an empty file' if not head else repr(head[:4])}; check the file, or export it again"
        )
    if len(head) < HEADER_BYTES[0]:
        raise _cut_short(path, f"a header of {HEADER_BYTES[0]} bytes", f"a file of {size_bytes} bytes")
    header = _parse(path, head, size_bytes)
    _check_layout(path, header)
    _check_scale(path, header)
    if header.n_points == 0:
        raise InputError(f"{path}: needs points, came a file that holds no points; export the scan again")
    if not header.is_compressed:
        _check_room(path, header)
    return header


def _cut_short(path: Path, needed: str, came: str) -> InputError:
    return InputError(
        f"{path}: needs {needed}, came {came}; the file is cut short or damaged, copy or export it again"
    )


def _parse(path: Path, head: bytes, size_bytes: int) -> LasHeader:
    major, minor = head[24], head[25]
    if major != 1 or minor not in HEADER_BYTES:
        raise InputError(f"{path}: needs LAS 1.0 to 1.4, came version {major}.{minor}; export LAS or LAZ 1.4")
    if len(head) < HEADER_BYTES[minor]:
        raise _cut_short(path, f"a header of {HEADER_BYTES[minor]} bytes", f"a file of {size_bytes} bytes")
    header_bytes, points_at, n_records, format_byte, record_bytes, n_points = struct.unpack_from(
        "<HIIBHI", head, 94
    )
    numbers = np.frombuffer(head, "<f8", 12, 131)
    (waveforms_at,) = struct.unpack_from("<Q", head, 227) if minor >= 3 else (0,)
    late_records_at, n_late_records, n_points_64 = (
        struct.unpack_from("<QIQ", head, 235) if minor >= 4 else (0, 0, n_points)
    )
    if n_points not in {0, n_points_64}:
        raise InputError(
            f"{path}: needs one count of points, came {n_points} and {n_points_64} in the same header; export it again"
        )
    return LasHeader(
        minor=minor,
        header_bytes=header_bytes,
        points_at=points_at,
        n_records=n_records,
        point_format=format_byte & ~COMPRESSED_BIT,
        is_compressed=bool(format_byte & COMPRESSED_BIT),
        record_bytes=record_bytes,
        n_points=n_points_64,
        n_by_return=sum(
            struct.unpack_from("<15Q", head, 255) if minor >= 4 else struct.unpack_from("<5I", head, 111)
        ),
        scale=numbers[:3],
        shift=numbers[3:6],
        low=numbers[7::2],
        high=numbers[6::2],
        waveforms_at=waveforms_at,
        n_late_records=n_late_records,
        late_records_at=late_records_at,
        size_bytes=size_bytes,
    )


def _check_layout(path: Path, header: LasHeader) -> None:
    if not HEADER_BYTES[header.minor] <= header.header_bytes <= header.points_at:
        raise _cut_short(
            path,
            f"a header of at least {HEADER_BYTES[header.minor]} bytes before the points",
            f"{header.header_bytes} bytes, and points from byte {header.points_at}",
        )
    if header.points_at > header.size_bytes:
        raise _cut_short(path, f"points from byte {header.points_at}", f"a file of {header.size_bytes} bytes")
    if header.point_format >= len(RECORD_BYTES):
        raise InputError(
            f"{path}: needs a point format from 0 to {len(RECORD_BYTES) - 1}, came {header.point_format}; "
            "the file is damaged, or newer than this program: export LAS or LAZ 1.4"
        )
    if header.record_bytes < RECORD_BYTES[header.point_format]:
        raise _cut_short(
            path,
            f"point records of at least {RECORD_BYTES[header.point_format]} bytes for format {header.point_format}",
            f"records of {header.record_bytes} bytes",
        )


def _check_scale(path: Path, header: LasHeader) -> None:
    if not (
        np.isfinite(header.scale).all() and np.isfinite(header.shift).all() and (header.scale > 0.0).all()
    ):
        raise InputError(
            f"{path}: needs positive scale factors and finite offsets, came {header.scale.tolist()} and "
            f"{header.shift.tolist()}; the header is damaged, export the scan again"
        )


def _check_room(path: Path, header: LasHeader) -> None:
    """Compare the count of a LAS file with the room between the first point and whatever comes after the last."""
    end_of_points = header.points_at + header.n_points * header.record_bytes
    after_points = [header.size_bytes]
    if header.n_late_records and header.late_records_at >= end_of_points:
        after_points.append(header.late_records_at)
    if header.waveforms_at >= end_of_points:
        after_points.append(header.waveforms_at)
    n_that_fit, rest = divmod(min(after_points) - header.points_at, header.record_bytes)
    if n_that_fit < header.n_points:
        raise _cut_short(
            path,
            f"the {header.n_points} points that its header states",
            f"room for {n_that_fit} points of {header.record_bytes} bytes",
        )
    if n_that_fit > header.n_points and rest == 0:
        raise InputError(
            f"{path}: needs as many points as its header states, {header.n_points}, came {n_that_fit}; "
            "the program that wrote it did not finish, export the scan again"
        )
