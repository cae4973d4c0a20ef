"""Ingest: the points of a file, whole and checked, in metres.

A format is one file of this folder with a module-level ``READER``; it is found by itself.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

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
    Reader,
    Scan,
    ScanHeader,
    ScanPart,
    ScanRequest,
)
from tasks.ingest.soundness import check_extent, check_finite, check_step, without_empty_returns

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
    "ScanHeader",
    "ScanPart",
    "ScanRequest",
    "describe_scan",
    "read_scan",
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
    try:
        raw = reader.read(path, request)
        check_finite(path, raw.values)
        points_m, notes = _points_and_notes(path, raw, request)
        levelled = level_scan(path, points_m, _in_metres(raw, request), request.levelling)
    except OSError as error:
        raise InputError(f"{path}: needs a readable file, came {error.strerror or error}") from error
    except MemoryError as error:
        raise InputError(
            f"{path}: needs more memory than this machine has; crop the scan to the structure and its surroundings"
        ) from error
    notes = (*raw.notes, *notes, *levelled.notes)
    return Scan(np.ascontiguousarray(levelled.points_m), len(raw.values), notes, levelled.pose)


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
    try:
        return _reader_of(path).describe(path, request)
    except OSError as error:
        raise InputError(f"{path}: needs a readable file, came {error.strerror or error}") from error


def _reader_of(path: Path) -> Reader:
    if not path.exists():
        raise InputError(f"{path}: needs a scan, came no such file; check the path in the campaign file")
    if not path.is_file():
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
