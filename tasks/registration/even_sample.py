"""An even sample of a large scan, in one pass and the same on every machine."""

from collections.abc import Iterable
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

CHUNK: Final = 1 << 18
"""Points that are looked at in one go: 6 MB."""

GOLDEN: Final = np.uint64(0x9E3779B97F4A7C15)
MIX: Final = ((np.uint64(30), np.uint64(0xBF58476D1CE4E5B9)), (np.uint64(27), np.uint64(0x94D049BB133111EB)))
LAST: Final = np.uint64(31)


class ChunkedCloud(Protocol):
    """A cloud that is read piece by piece: its number of points, and pieces (m, 3) of at most ``size``, metres."""

    def __len__(self) -> int:
        """Return the number of points."""
        ...

    def chunks(self, size: int) -> Iterable[NDArray[np.float64]]:
        """Give the points in their order."""
        ...


Cloud = NDArray[np.float64] | ChunkedCloud


def sampled(cloud: Cloud, most: int) -> NDArray[np.float64]:
    """Points (k, 3) of a cloud: all, in their order, where they are no more than ``most``, else an even sample.

    Memory beyond the input is that of the sample and of one chunk.

    Raises
    ------
    ShapeError
        If the pieces of a cloud hold more or fewer points than it says.
    """
    if isinstance(cloud, np.ndarray):
        return cloud if len(cloud) <= most else np.asarray(cloud[even_sample(len(cloud), most)])
    wanted = even_sample(len(cloud), most)
    kept, start = np.empty((len(wanted), 3)), 0
    for chunk in cloud.chunks(CHUNK):
        low, high = np.searchsorted(wanted, (start, start + len(chunk)))
        kept[low:high] = chunk[wanted[low:high] - start]
        start += len(chunk)
    if start != len(cloud):
        raise ShapeError(f"a cloud of {len(cloud)} points gave {start}")
    return kept


def even_sample(n: int, most: int) -> NDArray[np.int64]:
    """Ascending indices of ``most`` of ``n`` points: one of each of as many equal rows; all where there are no more.

    Which one is drawn by a hash of the row's number (splitmix64): a fixed place would follow the scan lines, of which a
    sample of every tenth point may hold the same tenth only.

    References
    ----------
    Steele, Lea & Flood 2014, Fast splittable pseudorandom number generators, OOPSLA.
    """
    if n <= most:
        return np.arange(n)
    edges = np.arange(most + 1, dtype=np.int64) * n // most
    lengths = np.diff(edges).astype(np.uint64)
    return np.asarray(edges[:-1] + (_hash(most) % lengths).astype(np.int64))


def _hash(n: int) -> NDArray[np.uint64]:
    """Numbers (n,) without pattern."""
    mixed = np.arange(1, n + 1, dtype=np.uint64) * GOLDEN
    for shift, factor in MIX:
        mixed = (mixed ^ (mixed >> shift)) * factor
    return np.asarray(mixed ^ (mixed >> LAST))
