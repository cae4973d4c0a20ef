"""Points that say what an earlier one said."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.side_by_side import side_by_side

POINTS_OF_LAYER: Final = 1 << 19
"""Points looked at together: their table takes some 10 MB."""


def find_duplicates(points_m: NDArray[np.float64], voxel_m: float) -> NDArray[np.bool_]:
    """Tell which of points (n, 3) share a cube of ``voxel_m`` with an earlier one.

    The first in the order of input stays, so the choice depends on no measured value.
    """
    from tasks.preprocessing.kernels import EMPTY, mark_first  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    first = np.zeros(len(points_m), dtype=np.bool_)
    if not len(points_m):
        return first
    low_m = points_m.min(axis=0)

    def mark(rows: NDArray[np.int64]) -> None:
        room = 1 << int(2 * len(rows)).bit_length()
        mark_first(points_m, rows, low_m, voxel_m, np.full(room, EMPTY), first)

    side_by_side(mark, _layers(points_m[:, 2], low_m[2], voxel_m))
    return ~first


def _layers(z_m: NDArray[np.float64], low_m: float, voxel_m: float) -> list[NDArray[np.int64]]:
    """Indices of the points of layers of whole cubes, each in the order of input."""
    cube = np.floor((z_m - low_m) / voxel_m)
    height = float(cube.max()) + 1.0
    count = int(min(max(len(z_m) // POINTS_OF_LAYER, 1), height, np.iinfo(np.int16).max))
    layer = (cube // np.ceil(height / count)).astype(np.int16)
    order = np.argsort(layer, kind="stable")
    return np.split(order, np.cumsum(np.bincount(layer, minlength=count))[:-1])
