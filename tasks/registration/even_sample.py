"""An even sample of a large scan, in one pass and the same on every machine."""

from collections.abc import Iterable
from typing import Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.even_choice import even_sample

CHUNK: Final = 1 << 18
"""Points that are looked at in one go: 6 MB."""


class ChunkedCloud(Protocol):
    """A cloud that is read piece by piece: its number of points, and pieces (m, 3) of at most ``size``, metres."""

    def __len__(self) -> int:
        """Return the number of points."""
        ...

    def chunks(self, size: int) -> Iterable[NDArray[np.float64]]:
        """Give the points in their order."""
        ...


@runtime_checkable
class StoredPoints(Protocol):
    """A cloud that makes metres of the points that are asked for alone: three times as fast as all in chunks."""

    def taken(self, rows: NDArray[np.int64]) -> NDArray[np.float64]:
        """Give the points (k, 3) at ascending indices (k,)."""
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
    if isinstance(cloud, StoredPoints):
        return cloud.taken(wanted)
    kept, start = np.empty((len(wanted), 3)), 0
    for chunk in cloud.chunks(CHUNK):
        low, high = np.searchsorted(wanted, (start, start + len(chunk)))
        kept[low:high] = chunk[wanted[low:high] - start]
        start += len(chunk)
    if start != len(cloud):
        raise ShapeError(f"a cloud of {len(cloud)} points gave {start}")
    return kept
