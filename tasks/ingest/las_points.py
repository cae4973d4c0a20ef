"""The points of a LAS or LAZ file whose header, records and chunks agree, decoded piece by piece."""

import logging
import mmap
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.crs import StatedSystem, check_horizontal, stated_systems
from tasks.ingest.las_header import LasHeader, read_las_header
from tasks.ingest.las_records import read_las_records
from tasks.ingest.las_units import check_units
from tasks.ingest.laz_chunks import packed_points, read_chunks
from tasks.ingest.laz_decoder import COORDINATES, EXTRA, Packed, Wanted, decoded_records
from tasks.ingest.scan import ScanRequest
from tasks.ingest.third_party import decoding

if TYPE_CHECKING:
    import laspy

PIECE_BYTES: Final = 16 << 20
"""Of decoded records, looked at at a time; of a LAZ file so many more are decoded meanwhile."""

READ_BYTES: Final = 8 << 20
"""Of records that need no decoding, read at a time: they stay in the processor's cache."""

PARALLEL_CHUNK_BYTES: Final = 32 << 20
"""The parallel decoder allocates a whole chunk a core; of a larger one the sequential decoder takes what is asked."""

# laspy logs what it also raises; without a handler Python would print that to stderr
logging.getLogger("laspy").addHandler(logging.NullHandler())


@dataclass(frozen=True, slots=True)
class CheckedLas:
    """What is known of a file whose header, records and chunks agree.

    ``packed`` are its points where they are compressed, and ``chunk_points`` the size of its largest chunk, else 0.
    """

    header: LasHeader
    packed: Packed | None
    chunk_points: int
    systems: tuple[StatedSystem, ...]
    notes: tuple[str, ...]

    @property
    def piece_points(self) -> int:
        """Points to decode at a time: whole chunks, where these are small."""
        most = max(1, PIECE_BYTES // self.header.record_bytes)
        return most - most % self.chunk_points if 0 < self.chunk_points < most else most

    def wanted(self, selection: int) -> Wanted:
        """How to decode it."""
        record_bytes = self.header.record_bytes
        in_parallel = self.chunk_points * record_bytes <= PARALLEL_CHUNK_BYTES
        return Wanted(self.header.n_points, record_bytes, self.piece_points, selection, in_parallel)


def check_las(path: Path, request: ScanRequest) -> CheckedLas:
    """Check all that can be checked without decoding points.

    Raises
    ------
    InputError
        If header, records, chunks and the size of the file do not agree, or another unit or system is stated than asked.
    """
    with path.open("rb") as file:
        header = read_las_header(path, file)
        records = read_las_records(path, file, header)
        notes = check_units(path, records, request.unit)
        systems = stated_systems(records)
        notes += check_horizontal(path, systems, request.horizontal) + _note_returns(header)
        if not header.is_compressed:
            return CheckedLas(header, None, 0, systems, notes)
        largest = max(chunk.n_points for chunk in read_chunks(path, file, header, records))
    return CheckedLas(header, packed_points(path, header, records), largest, systems, notes)


def _note_returns(header: LasHeader) -> tuple[str, ...]:
    """Tell of a count that is too small; a LAS file has room to compare it with, one chunk of LAZ has not."""
    if header.n_by_return <= header.n_points:
        return ()
    return (
        f"its header counts {header.n_by_return} points by return and {header.n_points} in all: damaged, or stale "
        "counts by return",
    )


def decoded_integers(path: Path, checked: CheckedLas) -> Iterator[NDArray[np.int32]]:
    """X, Y and Z as they are stored, (m, 3) a piece; each is overwritten by the next.

    Raises
    ------
    InputError
        If the points cannot be decoded, or are fewer than the header states.
    """
    integers = np.empty((0, 3), np.int32)
    with path.open("rb") as file:
        _laspy_header(path, file)
        for records in _records(path, file, checked, COORDINATES):
            if len(records) > len(integers):
                integers = returned_memory(12 * len(records)).view(np.dtype("<i4")).reshape(-1, 3)
            yield _coordinates(records, integers[: len(records)])


def decoded_extra(
    path: Path, checked: CheckedLas, find: Callable[[Path, Sequence[str]], tuple[int, int, int]]
) -> NDArray[np.float64]:
    """Three extra dimensions, (n, 3), that are found by the names of all.

    Raises
    ------
    InputError
        If they are not there, cannot be decoded, or the points are fewer than the header states.
    """
    from laspy.point.record import ScaleAwarePointRecord  # noqa: PLC0415 (slow to import)

    with path.open("rb") as file:
        header = _laspy_header(path, file)
        names = list(header.point_format.extra_dimension_names)
        columns = [names[index] for index in find(path, names)]
        values = np.empty((checked.header.n_points, 3))
        done = 0
        for records in _records(path, file, checked, EXTRA):
            piece = values[done : done + len(records)]
            done += len(records)
            with decoding(path):
                array = records.reshape(-1).view(header.point_format.dtype())
                points = ScaleAwarePointRecord(array, header.point_format, header.scales, header.offsets)
            # what is beyond float64 is refused by those who check all formats
            with np.errstate(over="ignore", invalid="ignore"):
                for index, name in enumerate(columns):
                    piece[:, index] = points[name]
    return values


def _laspy_header(path: Path, file: BufferedReader) -> "laspy.LasHeader":
    """Header as laspy reads it, which also refuses what it does not know."""
    from laspy import LasHeader as KnownHeader  # noqa: PLC0415 (slow to import)

    with decoding(path):
        return KnownHeader.read_from(file, read_evlrs=False)


def _records(
    path: Path, file: BufferedReader, checked: CheckedLas, selection: int
) -> Iterator[NDArray[np.uint8]]:
    """Records (m, bytes of a record); each piece is overwritten by the next."""
    if checked.packed is None:
        return _read(path, file, checked)
    return decoded_records(checked.packed, checked.wanted(selection))


def _read(path: Path, file: BufferedReader, checked: CheckedLas) -> Iterator[NDArray[np.uint8]]:
    """Records (m, bytes of a record) of a file that is not compressed; each piece is overwritten by the next."""
    n_points, record_bytes = checked.header.n_points, checked.header.record_bytes
    n_piece = min(max(1, READ_BYTES // record_bytes), n_points)
    buffer = returned_memory(n_piece * record_bytes).reshape(-1, record_bytes)
    file.seek(checked.header.points_at)
    for done in range(0, n_points, len(buffer)):
        piece = buffer[: n_points - done]
        count = file.readinto(piece.data.cast("B")) // record_bytes
        if count < len(piece):
            raise _too_few(path, n_points, done + count)
        yield piece


def _coordinates(records: NDArray[np.uint8], integers: NDArray[np.int32]) -> NDArray[np.int32]:
    """X, Y and Z of records (m, bytes of a record), in ``integers`` (m, 3): first in all point formats, little-endian."""
    layout = np.dtype({"names": ["xyz"], "formats": ["V12"], "offsets": [0], "itemsize": records.shape[1]})
    # twelve bytes at once take half the time of three columns
    integers.view("V12")[:, 0] = records.view(layout)[:, 0]["xyz"]
    return integers


def returned_memory(n_bytes: int) -> NDArray[np.uint8]:
    """Memory (n,) of zeros that goes back to the system when it is dropped.

    Of what NumPy frees, glibc keeps some ten megabytes for every thread that ever read a scan.
    """
    if not hasattr(mmap, "MADV_HUGEPAGE"):
        return np.frombuffer(mmap.mmap(-1, n_bytes), np.uint8)
    memory = mmap.mmap(-1, n_bytes, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    # in pages of 4 kB the first touch of a buffer took a sixth of the time of decoding a million points
    with suppress(OSError):  # a kernel may know the word and not the thing
        memory.madvise(mmap.MADV_HUGEPAGE)
    return np.frombuffer(memory, np.uint8)


def _too_few(path: Path, n_points: int, came: int) -> InputError:
    return InputError(
        f"{path}: needs the {n_points} points that its header states, came {came}; "
        "the file is cut short or being written, copy or export it again"
    )
