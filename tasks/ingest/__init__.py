"""Ingest: the points of a file, whole and checked, in metres.

A format is one file of this folder with a module-level ``READER``; it is found by itself.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.geometry.variants import discover
from tasks.ingest.foreign_formats import ADVICE
from tasks.ingest.levelling import level_scan
from tasks.ingest.polar import cartesian_from_polar, check_polar
from tasks.ingest.scan import (
    METRES_PER_UNIT,
    Bounds,
    Coordinates,
    FilePose,
    Frame,
    LengthUnit,
    Levelling,
    RawScan,
    RawStream,
    Reader,
    Scan,
    ScanFacts,
    ScanHeader,
    ScanPart,
    ScanRequest,
    ScanStream,
)
from tasks.ingest.soundness import check_extent, check_finite, check_step, without_empty_returns
from tasks.ingest.stream import checked_pieces, grid_of_site

__all__ = [
    "AS_STATED",
    "READERS",
    "Bounds",
    "Coordinates",
    "FilePose",
    "Frame",
    "LengthUnit",
    "Levelling",
    "Reader",
    "Scan",
    "ScanFacts",
    "ScanHeader",
    "ScanPart",
    "ScanRequest",
    "ScanStream",
    "describe_scan",
    "read_scan",
    "stream_scan",
]

READERS: Final[Mapping[str, Reader]] = discover(__name__, "READER", Reader)
"""The readers by name."""

AS_STATED: Final = ScanRequest()
"""Cartesian coordinates in metres, origin and axes as in the file."""


def read_scan(path: Path, request: ScanRequest = AS_STATED) -> Scan:
    """Read all points of a file.

    The local origin is subtracted in float64 before anything else is done with the coordinates.

    Raises
    ------
    InputError
        If the file is missing, of an unknown format, cut short, empty, or holds coordinates that cannot be a scan
        in metres; the message says what was needed, what came and what to do.
    """
    reader = _reader_of(path)
    with _faults(path):
        raw = _raw_stream(reader, path, request)
        return _read_whole(path, reader, request) if raw is None else _joined(path, raw, request)


def stream_scan(path: Path, request: ScanRequest = AS_STATED) -> ScanStream:
    """Begin to read a file of any size in pieces; the points and checks are those of ``read_scan``.

    LAS and LAZ with Cartesian coordinates come as integers in memory that does not grow; all else is read whole, as one
    piece of float64.

    Raises
    ------
    InputError
        As ``read_scan``; here what the header shows, and the rest while the pieces are gone through.
    """
    reader = _reader_of(path)
    with _faults(path):
        raw = _raw_stream(reader, path, request)
    if raw is None:
        return ScanStream(None, lambda tell: _as_one_piece(path, reader, request, tell))
    return ScanStream(grid_of_site(raw.grid, request), lambda tell: _pieces(path, raw, request, tell))


def _raw_stream(reader: Reader, path: Path, request: ScanRequest) -> RawStream | None:
    if reader.stream is None or request.coordinates != "cartesian":
        return None
    return reader.stream(path, request)


def _pieces(
    path: Path, raw: RawStream, request: ScanRequest, tell: Callable[[ScanFacts], None]
) -> Iterator[NDArray[Any]]:
    with _faults(path):
        yield from checked_pieces(path, raw, request, tell)


def _as_one_piece(
    path: Path, reader: Reader, request: ScanRequest, tell: Callable[[ScanFacts], None]
) -> Iterator[NDArray[Any]]:
    with _faults(path):
        scan = _read_whole(path, reader, request)
    yield scan.points_m
    tell(ScanFacts(scan.n_in_file, scan.notes, scan.pose))


def _joined(path: Path, raw: RawStream, request: ScanRequest) -> Scan:
    """Put all pieces together; the count of points was held against the file before it is believed here."""
    facts: list[ScanFacts] = []
    points_m, done, grid = np.empty((raw.n_points, 3)), 0, grid_of_site(raw.grid, request)
    # what a damaged header scales beyond float64 is refused at the end, and needs no warning
    with np.errstate(over="ignore", invalid="ignore"):
        for piece in checked_pieces(path, raw, request, facts.append):
            grid.metres(piece, points_m[done : done + len(piece)])
            done += len(piece)
    return Scan(points_m[:done], facts[0].n_in_file, facts[0].notes, facts[0].pose)


def _read_whole(path: Path, reader: Reader, request: ScanRequest) -> Scan:
    raw = reader.read(path, request)
    check_finite(path, raw.values)
    points_m, notes = _points_and_notes(path, raw, request)
    levelled = level_scan(path, points_m, _in_metres(raw, request), request.levelling)
    notes = (*raw.notes, *notes, *levelled.notes)
    return Scan(np.ascontiguousarray(levelled.points_m), len(raw.values), notes, levelled.pose)


@contextmanager
def _faults(path: Path) -> Iterator[None]:
    """Turn what the system refuses into InputError."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: needs a readable file, came {error.strerror or error}") from error
    except MemoryError as error:
        raise InputError(
            f"{path}: needs more memory than this machine has; crop the scan to the structure and its surroundings"
        ) from error


def _in_metres(raw: RawScan, request: ScanRequest) -> FilePose | None:
    if raw.pose is None:
        return None
    return FilePose(raw.pose.rotation, raw.pose.translation * METRES_PER_UNIT[request.unit])


def describe_scan(path: Path, request: ScanRequest = AS_STATED) -> ScanHeader:
    """Say what the header of a file says, without reading its points.

    Raises
    ------
    InputError
        If the header alone shows that ``read_scan`` would refuse the file.
    """
    reader = _reader_of(path)
    with _faults(path):
        return reader.describe(path, request)


def _reader_of(path: Path) -> Reader:
    try:
        is_there, is_file = path.exists(), path.is_file()
    except OSError as fault:
        raise InputError(
            f"{path}: needs a scan, which cannot be looked at ({fault.strerror}); check the rights of its folders and "
            "the path in the campaign file"
        ) from fault
    if not is_there:
        raise InputError(f"{path}: needs a scan, came no such file; check the path in the campaign file")
    if not is_file:
        raise InputError(f"{path}: needs a file, came a folder; name the scan itself")
    suffix = path.suffix.lower()
    for reader in READERS.values():
        if suffix in reader.suffixes:
            return reader
    known = ", ".join(known for reader in READERS.values() for known in reader.suffixes)
    advice = ADVICE.get(suffix, "is unknown; export LAZ")
    raise InputError(f"{path}: needs one of {known}, came {suffix or 'no suffix'}, which {advice}")


def _points_and_notes(
    path: Path, raw: RawScan, request: ScanRequest
) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    metres = METRES_PER_UNIT[request.unit]
    if request.coordinates == "polar":
        polar, notes = without_empty_returns(path, raw.values, raw.values[:, 0] == 0.0)
        notes += check_polar(path, polar)
        points_m = cartesian_from_polar(polar)
    else:
        points_m, notes = without_empty_returns(path, raw.values, _is_origin(raw.values))
    if metres != 1.0:
        points_m = points_m * metres
    if request.coordinates == "cartesian":
        notes += check_step(path, points_m, None if raw.step is None else raw.step * metres)
    points_m = (
        points_m - np.asarray(request.origin_m, dtype=np.float64) if any(request.origin_m) else points_m
    )
    if request.swap_axes:
        points_m = points_m[:, (1, 0, 2)]
    return points_m, notes + check_extent(path, points_m)


def _is_origin(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which records (n, 3) are exactly zero in all three."""
    is_zero = values[:, 0] == 0.0
    is_zero &= values[:, 1] == 0.0
    is_zero &= values[:, 2] == 0.0
    return np.asarray(is_zero)
