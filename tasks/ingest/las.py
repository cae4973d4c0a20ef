"""LAS 1.0 to 1.4 and LAZ.

Cartesian coordinates come in pieces of bounded size, as the integers that the file holds. Polar ones (extra dimensions) are
read whole: memory is then bounded by the (n, 3) result, which is allocated from the count in the header. That is believed
only after it agreed with the size of the file (LAS) or with the chunk table and the chunks (LAZ); there is no ratio of
compression to guess.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.integer_grid import IntegerGrid
from tasks.ingest.column_names import find_columns
from tasks.ingest.crs import SAMPLE_POINTS, StatedSystem, note_grid_of_scanner
from tasks.ingest.las_header import LasHeader
from tasks.ingest.las_points import CheckedLas, check_las, decoded_extra, decoded_integers
from tasks.ingest.scan import Bounds, RawScan, RawStream, Reader, ScanHeader, ScanRequest
from tasks.ingest.soundness import sample_step
from tasks.ingest.stream import EverySo

OUTSIDE_STEPS: Final = 2.0
"""A point may lie this many steps of the scale factor outside the box of the header: rounding."""


def describe_las(path: Path, request: ScanRequest) -> ScanHeader:
    """What a LAS or LAZ header says, checked as far as that goes without decoding points."""
    checked = check_las(path, request)
    header = checked.header
    kind = "LAZ" if header.is_compressed else "LAS"
    return ScanHeader(
        f"{kind} 1.{header.minor}",
        header.n_points,
        header.size_bytes,
        Bounds(header.low.copy(), header.high.copy()),
        horizontal=checked.systems[0].label if checked.systems else None,
    )


def stream_las(path: Path, request: ScanRequest) -> RawStream:
    """The x, y, z of a LAS or LAZ file, as many as its header states."""
    checked = check_las(path, request)
    header = checked.header
    grid = IntegerGrid(_triple(header.scale), _triple(header.shift))
    return RawStream(
        header.n_points,
        grid,
        partial(decoded_integers, path, checked),
        _watch(checked, grid, request),
        checked.notes,
    )


def read_polar_las(path: Path, request: ScanRequest) -> RawScan:
    """The extra dimensions S, alpha and omega of a LAS or LAZ file, as many as its header states."""
    checked = check_las(path, request)
    values = decoded_extra(path, checked, partial(find_columns, coordinates=request.coordinates))
    return RawScan(values, notes=checked.notes)


@dataclass(slots=True)
class _LasWatch:
    """What a LAS header states of the points, held against them: their box and their coordinate system."""

    grid: IntegerGrid
    stated: Bounds | None
    """With room for rounding; None where it is no box."""
    systems: tuple[StatedSystem, ...]
    request: ScanRequest
    sample: EverySo
    n_seen: int = 0
    n_outside: int = 0

    def see(self, integers: NDArray[np.int32], box: Bounds) -> None:
        """Look at the next records (m, 3)."""
        self.n_seen += len(integers)
        self.sample.see(integers)
        if self.stated is not None:
            self.n_outside += self._count_outside(self.stated, integers, box)

    def notes(self) -> tuple[str, ...]:
        """Tell of points on a grid, and outside the box of the header: damage shows there, LAZ has no checksum."""
        found = note_grid_of_scanner(self.systems, self.grid.metres(self.sample.rows()), self.request)
        if self.stated is None:
            return (
                *found,
                "the box that the header states is no box; it could not be compared with the points",
            )
        if self.n_outside == 0:
            return found
        return (
            *found,
            f"{self.n_outside} of {self.n_seen} points lie outside the box that the header states: damaged, or a "
            "stale header",
        )

    def _count_outside(self, stated: Bounds, integers: NDArray[np.int32], box: Bounds) -> int:
        # a damaged header may scale beyond float64; the check for finite numbers then says so
        with np.errstate(over="ignore", invalid="ignore"):
            low, high = self.grid.metres(np.array([box.low, box.high]))
            if (low >= stated.low).all() and (high <= stated.high).all():
                return 0
            values = self.grid.metres(integers)
        return int(np.count_nonzero(((values < stated.low) | (values > stated.high)).any(axis=1)))


def _watch(checked: CheckedLas, grid: IntegerGrid, request: ScanRequest) -> _LasWatch:
    sample = EverySo(sample_step(checked.header.n_points, SAMPLE_POINTS))
    return _LasWatch(grid, _stated_box(checked.header), checked.systems, request, sample)


def _stated_box(header: LasHeader) -> Bounds | None:
    # what a damaged header scales beyond float64 is refused when its points are looked at
    with np.errstate(over="ignore", invalid="ignore"):
        if not (header.low <= header.high).all() or not np.isfinite(header.low + header.high).all():
            return None
        room = OUTSIDE_STEPS * header.scale
        return Bounds(header.low - room, header.high + room)


def _triple(numbers: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = numbers.tolist()
    return x, y, z


READER: Final = Reader("las", (".las", ".laz"), describe_las, read_polar_las, stream_las)
