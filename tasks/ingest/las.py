"""LAS 1.0 to 1.4 and LAZ.

Memory is bounded by the (n, 3) result and one piece of decoded records. The result is allocated from the count in
the header only after that count agreed with the size of the file (LAS) or with the chunk table and the chunks (LAZ);
there is no ratio of compression to guess.
"""

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from laspy import DecompressionSelection, LasReader, LazBackend
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.column_names import find_columns
from tasks.ingest.crs import StatedSystem, check_horizontal, note_grid_of_scanner, stated_systems
from tasks.ingest.las_header import LasHeader, read_las_header
from tasks.ingest.las_records import read_las_records
from tasks.ingest.las_units import check_units
from tasks.ingest.laz_chunks import read_chunks
from tasks.ingest.scan import COLUMN_NAMES, Bounds, RawScan, Reader, ScanHeader, ScanRequest, box_of
from tasks.ingest.third_party import decoding

PIECE_BYTES: Final = 64 << 20
"""Of decoded records, held at a time."""

PARALLEL_CHUNK_BYTES: Final = 256 << 20
"""The parallel decoder allocates a whole chunk; of a larger one the sequential decoder takes what is asked."""

OUTSIDE_STEPS: Final = 2.0
"""A point may lie this many steps of the scale factor outside the box of the header: rounding."""

# laspy logs what it also raises; without a handler Python would print that to stderr
logging.getLogger("laspy").addHandler(logging.NullHandler())


@dataclass(frozen=True, slots=True)
class _Checked:
    """What is known of a file whose header, records and chunks agree."""

    header: LasHeader
    backend: LazBackend
    systems: tuple[StatedSystem, ...]
    notes: tuple[str, ...]


def describe_las(path: Path, request: ScanRequest) -> ScanHeader:
    """What a LAS or LAZ header says, checked as far as that goes without decoding points."""
    with path.open("rb") as file:
        checked = _check(path, file, request)
    header = checked.header
    kind = "LAZ" if header.is_compressed else "LAS"
    return ScanHeader(
        f"{kind} 1.{header.minor}",
        header.n_points,
        header.size_bytes,
        Bounds(header.low.copy(), header.high.copy()),
        horizontal=checked.systems[0].label if checked.systems else None,
    )


def read_las(path: Path, request: ScanRequest) -> RawScan:
    """All points of a LAS or LAZ file, as many as its header states."""
    with path.open("rb") as file:
        checked = _check(path, file, request)
        header = checked.header
        file.seek(0)
        with decoding(path):
            reader = LasReader(
                file,
                closefd=False,
                laz_backend=checked.backend,
                read_evlrs=False,
                decompression_selection=_selection(request),
            )
            values = np.empty((header.n_points, 3))
            _fill(path, reader, values, _columns(path, reader, request))
    if request.coordinates == "polar":
        return RawScan(values, notes=checked.notes)
    notes = checked.notes + note_grid_of_scanner(checked.systems, values, request)
    return RawScan(values, float(header.scale.max()), notes + _outside_box(header, values))


def _check(path: Path, file: BinaryIO, request: ScanRequest) -> _Checked:
    header = read_las_header(path, file)
    records = read_las_records(path, file, header)
    notes = check_units(path, records, request.unit)
    systems = stated_systems(records)
    notes += check_horizontal(path, systems, request.horizontal)
    if not header.is_compressed:
        return _Checked(header, LazBackend.Lazrs, systems, notes)
    largest = max(chunk.n_points for chunk in read_chunks(path, file, header, records))
    is_large = largest * header.record_bytes > PARALLEL_CHUNK_BYTES
    return _Checked(header, LazBackend.Lazrs if is_large else LazBackend.LazrsParallel, systems, notes)


def _selection(request: ScanRequest) -> DecompressionSelection:
    """Nothing but what is asked for; the point formats before 6 cannot be decoded in part and ignore this."""
    if request.coordinates == "polar":
        return DecompressionSelection.base().decompress_all_extra_bytes()
    return DecompressionSelection.base().decompress_z()


def _columns(path: Path, reader: LasReader, request: ScanRequest) -> tuple[str, ...]:
    if request.coordinates == "cartesian":
        return COLUMN_NAMES["cartesian"]
    names = list(reader.header.point_format.extra_dimension_names)
    return tuple(names[index] for index in find_columns(path, names, request.coordinates))


def _fill(path: Path, reader: LasReader, values: NDArray[np.float64], columns: tuple[str, ...]) -> None:
    """Decode all points into values (n, 3), piece by piece."""
    piece = max(1, PIECE_BYTES // reader.header.point_format.size)
    done = 0
    while done < len(values):
        points = reader.read_points(min(piece, len(values) - done))
        if len(points) == 0:
            raise InputError(
                f"{path}: needs the {len(values)} points that its header states, came {done}; "
                "the file is cut short or being written, copy or export it again"
            )
        # a damaged header may scale beyond float64; the check for finite numbers then says so
        with np.errstate(over="ignore", invalid="ignore"):
            for index, name in enumerate(columns):
                values[done : done + len(points), index] = points[name]
        done += len(points)


def _outside_box(header: LasHeader, values: NDArray[np.float64]) -> tuple[str, ...]:
    """A note if points (n, 3) lie outside the box of the header: damage shows there, LAZ has no checksum."""
    if not (header.low <= header.high).all() or not np.isfinite(header.low + header.high).all():
        return ("the box that the header states is no box; it could not be compared with the points",)
    low, high = header.low - OUTSIDE_STEPS * header.scale, header.high + OUTSIDE_STEPS * header.scale
    box = box_of(values)
    if (box.low >= low).all() and (box.high <= high).all():
        return ()
    n_outside = int(np.count_nonzero(((values < low) | (values > high)).any(axis=1)))
    return (
        f"{n_outside} of {len(values)} points lie outside the box that the header states: damaged, or a stale header",
    )


READER: Final = Reader("las", (".las", ".laz"), describe_las, read_las)
