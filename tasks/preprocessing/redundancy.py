"""Points that say what an earlier one said."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.side_by_side import side_by_side

POINTS_OF_LAYER: Final = 1 << 19
"""Points looked at together: their table takes some 10 MB."""


def find_duplicates(
    points_m: NDArray[np.float64], among: NDArray[np.bool_], voxel_m: float
) -> NDArray[np.bool_]:
    """Tell which of points (n, 3) share a cube of ``voxel_m`` with an earlier one; only those ``among`` (n,) count.

    The first in the order of input stays, so the choice depends on no measured value.

    Raises
    ------
    ShapeError
        If there are more than 2,147,483,647 points.
    """
    from tasks.preprocessing.kernels import EMPTY, mark_first  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    later = among.copy()
    if not among.any():
        return later
    low_m = np.array([column.min(where=among, initial=np.inf) for column in points_m.T])
    first = np.zeros(len(points_m), dtype=np.bool_)

    def mark(layer: NDArray[np.int32]) -> None:
        room = 1 << int(2 * len(layer)).bit_length()
        mark_first(points_m, layer, low_m, voxel_m, np.full(room, EMPTY, dtype=np.int32), first)

    side_by_side(mark, _layers(points_m[:, 2], among, low_m[2], voxel_m))
    later[first] = False
    return later


def _layers(
    z_m: NDArray[np.float64], among: NDArray[np.bool_], low_m: float, voxel_m: float
) -> list[NDArray[np.int32]]:
    """Rows of the points ``among`` heights (n,) by layers of whole cubes, each in the order of input."""
    from tasks.geometry.layer_kernel import rows_of_cube_layers  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    if len(z_m) > np.iinfo(np.int32).max:
        raise ShapeError(f"find_duplicates needs at most {np.iinfo(np.int32).max} points, got {len(z_m)}")
    height = np.floor((z_m.max(where=among, initial=-np.inf) - low_m) / voxel_m) + 1.0
    count = int(min(max(np.count_nonzero(among) // POINTS_OF_LAYER, 1), height, np.iinfo(np.int16).max))
    rows, begins = rows_of_cube_layers(
        z_m, among, float(low_m), voxel_m, float(np.ceil(height / count)), count
    )
    return np.split(rows, begins[1:-1])
