"""Points that stand alone on the surface of a shaft."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.side_by_side import side_by_side
from tasks.preprocessing.bands import split_bands

CELL_SPACINGS: Final = 4.0
"""Side of a cell in mean spacings of the points: 16 points a cell and 144 in its neighbourhood are then usual."""

SPARSER: Final = 4.0
"""A band's spacing counts up to this many times that of the whole: far ends are sparse, hidden bands hold strays."""


def find_isolated(
    around_m: NDArray[np.float64],
    up_m: NDArray[np.float64],
    edges_m: NDArray[np.float64],
    min_neighbours: int,
) -> NDArray[np.bool_]:
    """Tell which points have fewer than ``min_neighbours`` others near them, as near as is usual at their height.

    Parameters
    ----------
    around_m, up_m : (n,) arrays
        Position on the unrolled surface: arc length and height, metres. The seam is not closed.
    edges_m : (k + 1,) array
        Edges of the height bands, each judged by its own density.
    min_neighbours : int
        The others that a point needs.
    """
    isolated = np.zeros(len(up_m), dtype=np.bool_)
    if not len(up_m):
        return isolated
    sparse_m = SPARSER * _spacing_m(around_m, up_m)

    def judge(rows: NDArray[np.int64]) -> None:
        if len(rows):
            around, up = around_m[rows], up_m[rows]
            cell_m = CELL_SPACINGS * min(_spacing_m(around, up), sparse_m)
            isolated[rows] = _neighbours(around, up, cell_m) < min_neighbours

    side_by_side(judge, split_bands(up_m, edges_m))
    return isolated


def _neighbours(around_m: NDArray[np.float64], up_m: NDArray[np.float64], cell_m: float) -> NDArray[np.int64]:
    """Other points (n,) in the cell of each point and the eight around it."""
    column = ((around_m - around_m.min()) / cell_m).astype(np.int64) + 1
    row = ((up_m - up_m.min()) / cell_m).astype(np.int64) + 1
    shape = (int(row.max()) + 2, int(column.max()) + 2)
    counts = np.bincount(row * shape[1] + column, minlength=shape[0] * shape[1]).reshape(shape)
    along = counts.copy()
    along[:, 1:-1] += counts[:, :-2] + counts[:, 2:]
    nearby = along.copy()
    nearby[1:-1] += along[:-2] + along[2:]
    return np.asarray(nearby[row, column] - 1)


def _spacing_m(around_m: NDArray[np.float64], up_m: NDArray[np.float64]) -> float:
    """Mean spacing of points spread over the box that holds them, metres; never zero."""
    around, up = float(np.ptp(around_m)), float(np.ptp(up_m))
    return max(float(np.sqrt(around * up / len(up_m))), 1e-6 * (1.0 + around + up))
