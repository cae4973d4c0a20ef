"""Clouds of points as artifacts: written in a stream, read in parts.

A file ``.cloud`` is its points, row after row and little-endian, then a trailer of 128 bytes: int32 (n, 3) with the grid
that makes metres of them where a scanner's file holds integers (12 bytes a point), else float64 (n, 3) metres. The trailer
comes last because the number of points is known last: the digest is computed while the points go by.

    cloud = open_cloud(ws, ref)         # reads the trailer
    for points_m in cloud.chunks():     # (m, 3) float64, metres
        ...
"""

import hashlib
import math
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from storage.artifacts import ArtifactRef, damaged_artifact, present_artifact, put_written
from storage.errors import ShapeError, StorageError
from storage.integer_grid import IntegerGrid
from storage.workspace import Workspace

EXT: Final = "cloud"
MAGIC: Final = b"tw-cloud"
TRAILER: Final = struct.Struct("<8sIIQ10d24x")
"""Magic, version and whether integers, whether axes are swapped, points; scale, shift, unit and origin of the grid."""

VERSION: Final = 1
AS_INTEGERS: Final = 1 << 16
"""Added to the version where the points are integers."""

CHUNK_POINTS: Final = 1 << 18
"""Points of a chunk unless asked otherwise: 6 MB as float64."""

SEEK_FROM: Final = 512
"""A sample of every so many points is read point by point; a closer one is taken out of whole chunks."""

FINGERPRINT_POINTS: Final = 1 << 16


@dataclass(frozen=True, slots=True)
class StoredCloud:
    """A stored cloud of points; nothing of it stays in memory or open between two calls, so threads may share it.

    Every method raises StorageError if the file is gone or damaged.
    """

    path: Path
    n_points: int
    grid: IntegerGrid | None
    starts_at: int = 0
    """Byte of the first point."""

    def __len__(self) -> int:
        """Count its points."""
        return self.n_points

    def chunks(self, size: int = CHUNK_POINTS) -> Iterator[NDArray[np.float64]]:
        """Give all points in order as arrays (m, 3), metres, m = ``size`` but for the last; each array is a new one."""
        # held open: the copy of an object on S3 may leave its cache meanwhile
        with _reading(self.path) as file:
            for start in range(0, self.n_points, size):
                points_m = np.empty((min(start + size, self.n_points) - start, 3))
                self._fill(file, start, points_m)
                yield points_m

    def rows(self, start: int, stop: int) -> NDArray[np.float64]:
        """Give the points from ``start`` up to, not with, ``stop``: (stop - start, 3), metres.

        Raises
        ------
        ShapeError
            If the cloud has no such points.
        """
        if not 0 <= start <= stop <= self.n_points:
            raise ShapeError(f"needs points from 0 to {self.n_points}; got {start} to {stop}")
        points_m = np.empty((stop - start, 3))
        with _reading(self.path) as file:
            self._fill(file, start, points_m)
        return points_m

    def whole(self) -> NDArray[np.float64]:
        """Give all points (n, 3), metres, C order; 24 bytes a point."""
        return self.rows(0, self.n_points)

    def taken(self, rows: NDArray[np.int64]) -> NDArray[np.float64]:
        """Give the points (k, 3) at some indices (k,), metres: all are read, only these are made metres.

        Raises
        ------
        ShapeError
            If the indices do not ascend, or the cloud has no such points.
        """
        if len(rows) and not (rows[0] >= 0 and rows[-1] < self.n_points and (rows[1:] > rows[:-1]).all()):
            raise ShapeError(
                f"needs ascending indices from 0 to {self.n_points - 1}; got {rows[0]} to {rows[-1]}"
            )
        points_m = np.empty((len(rows), 3))
        block = np.empty((min(CHUNK_POINTS, self.n_points), 3), self._dtype)
        with _reading(self.path) as file:
            for start in range(0, self.n_points, CHUNK_POINTS):
                first, last = np.searchsorted(rows, (start, start + CHUNK_POINTS))
                if first < last:
                    piece = block[: self.n_points - start]
                    self._read(file, start, piece)
                    self._metres(piece.take(rows[first:last] - start, axis=0), points_m[first:last])
        return points_m

    def sample(self, most: int) -> NDArray[np.float64]:
        """Give every k-th point from the first on, (m, 3), metres: the least k by which m is at most ``most``.

        Raises
        ------
        ShapeError
            If ``most`` is less than 1.
        """
        if most < 1:
            raise ShapeError(f"needs a sample of at least 1 point; got {most}")
        step = max(1, math.ceil(self.n_points / most))
        taken = np.empty((math.ceil(self.n_points / step), 3), self._dtype)
        with _reading(self.path) as file:
            if step >= SEEK_FROM:
                for index in range(len(taken)):
                    self._read(file, index * step, taken[index : index + 1])
            else:
                self._thin(file, step, taken)
        return self._metres(taken, np.empty(taken.shape))

    def fingerprint(self) -> str:
        """SHA-256, in hex, of the number of points and an even sample of them in metres, however they are stored."""
        digest = hashlib.sha256(str(self.n_points).encode())
        # adding 0 makes one zero of the two
        digest.update((self.sample(FINGERPRINT_POINTS) + 0.0).astype("<f8").tobytes())
        return digest.hexdigest()

    @property
    def _dtype(self) -> np.dtype[Any]:
        return np.dtype("<f8" if self.grid is None else "<i4")

    def _thin(self, file: FileIO, step: int, taken: NDArray[Any]) -> None:
        block = np.empty((step * max(1, CHUNK_POINTS // step), 3), self._dtype)
        done = 0
        for start in range(0, self.n_points, len(block)):
            piece = block[: min(len(block), self.n_points - start)]
            self._read(file, start, piece)
            kept = piece[::step]
            taken[done : done + len(kept)] = kept
            done += len(kept)

    def _fill(self, file: FileIO, start: int, points_m: NDArray[np.float64]) -> None:
        """Read points (m, 3) from ``start`` on into an array of metres."""
        if self.grid is None:
            self._read(file, start, points_m)
            return
        block = np.empty((min(CHUNK_POINTS, len(points_m)), 3), self._dtype)
        for first in range(0, len(points_m), CHUNK_POINTS):
            into = points_m[first : first + CHUNK_POINTS]
            self._read(file, start + first, block[: len(into)])
            self._metres(block[: len(into)], into)

    def _metres(self, stored: NDArray[Any], into: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.grid is not None:
            return self.grid.metres(stored, into)
        into[:] = stored
        return into

    def _read(self, file: FileIO, start: int, into: NDArray[Any]) -> None:
        """Read stored rows into an array (m, 3) in C order."""
        if len(into) == 0:
            return
        file.seek(self.starts_at + start * 3 * into.itemsize)
        room = into.data.cast("B")
        done = 0
        while done < len(room):
            count = file.readinto(room[done:])
            if not count:
                raise damaged_artifact(self.path, f"it ends within point {start + len(into)}")
            done += count


def put_cloud(
    ws: Workspace, kind: str, pieces: Iterable[NDArray[Any]], grid: IntegerGrid | None = None
) -> ArtifactRef:
    """Store a cloud from pieces as they come; what an iterator of pieces raises leaves nothing behind.

    Parameters
    ----------
    ws : Workspace
        Whose store keeps it.
    kind : str
        What the cloud is, for messages.
    pieces : iterable of (m, 3) arrays
        int32 with a grid, else float64, metres. How a cloud is cut into pieces does not change its digest.
    grid : IntegerGrid or None
        What makes metres of the integers.

    Raises
    ------
    ShapeError
        If a piece is anything else.
    StorageError
        If the disk refuses.
    """
    dtype = np.dtype(np.float64 if grid is None else np.int32)

    def write(file: BinaryIO) -> None:
        n_points = 0
        for piece in pieces:
            if piece.dtype != dtype or piece.ndim != 2 or piece.shape[1] != 3:
                raise ShapeError(
                    f"cloud {kind!r} needs pieces (m, 3) of {dtype}; got {piece.shape} of {piece.dtype}"
                )
            plain = np.ascontiguousarray(piece, dtype=dtype.newbyteorder("<"))
            if len(plain):
                file.write(plain.data.cast("B"))
            n_points += len(plain)
        file.write(_trailer(n_points, grid))

    return put_written(ws, kind, EXT, write)


def open_cloud(ws: Workspace, ref: ArtifactRef) -> StoredCloud:
    """Open a stored cloud, or an array (n, 3) of float64 that was stored as .npy.

    Raises
    ------
    StorageError
        If it is absent, damaged or no cloud.
    """
    path = present_artifact(ws, ref)
    with _reading(path) as file:
        if ref.ext == EXT:
            return _cloud_of(path, file)
        try:
            return _cloud_of_array(path, file)
        except ValueError as fault:
            raise damaged_artifact(path, str(fault)) from fault


def _trailer(n_points: int, grid: IntegerGrid | None) -> bytes:
    if grid is None:
        return TRAILER.pack(MAGIC, VERSION, 0, n_points, *([0.0] * 10))
    numbers = (*grid.scale, *grid.shift, grid.unit_m, *grid.origin_m)
    return TRAILER.pack(MAGIC, VERSION + AS_INTEGERS, int(grid.swap_axes), n_points, *numbers)


def _cloud_of(path: Path, file: FileIO) -> StoredCloud:
    room = file.seek(0, 2) - TRAILER.size
    if room < 0:
        raise damaged_artifact(path, "it has no trailer")
    file.seek(room)
    magic, form, swapped, n_points, *numbers = TRAILER.unpack(file.read(TRAILER.size))
    if magic != MAGIC or form not in {VERSION, VERSION + AS_INTEGERS}:
        raise damaged_artifact(path, "its trailer is not that of a cloud of this version")
    row_bytes = 24 if form == VERSION else 12
    if n_points * row_bytes != room:
        raise damaged_artifact(path, f"its trailer states {n_points} points, it has {room} bytes of them")
    if form == VERSION:
        return StoredCloud(path, n_points, None)
    scale, shift, origin_m = tuple(numbers[:3]), tuple(numbers[3:6]), tuple(numbers[7:])
    return StoredCloud(path, n_points, IntegerGrid(scale, shift, numbers[6], origin_m, bool(swapped)))


def _cloud_of_array(path: Path, file: FileIO) -> StoredCloud:
    if np.lib.format.read_magic(file) != (1, 0):
        raise damaged_artifact(path, "it is no array of version 1.0")
    shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(file)
    if len(shape) != 2 or shape[1] != 3 or is_fortran or dtype != np.dtype("<f8"):
        raise StorageError(f"artifact {path} needs points (n, 3) of float64; it holds {shape} of {dtype}")
    starts_at = file.tell()
    if file.seek(0, 2) - starts_at != shape[0] * 24:
        raise damaged_artifact(path, f"its header states {shape[0]} points")
    return StoredCloud(path, shape[0], None, starts_at)


def _reading(path: Path) -> FileIO:
    try:
        return path.open("rb", buffering=0)
    except OSError as fault:
        raise damaged_artifact(path, str(fault)) from fault
