"""The loops over all points of a cloud that isolating a shaft needs, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

NEAREST_M: Final = 1e-9
"""A point on the axis has no direction; nearer ones count as that far."""

EMPTY: Final = -1

Cube = tuple[int, int, int]


@compiled
def place_points(  # noqa: PLR0913, PLR0917 - a compiled loop
    points_m: NDArray[np.float64],
    low_m: float,
    step_m: float,
    values_m: NDArray[np.float64],
    off_m: NDArray[np.float64],
    around_m: NDArray[np.float64],
    radius_m: NDArray[np.float64],
) -> None:
    """Place points (n, 3) about a surface with knots every ``step_m`` from ``low_m`` on.

    ``values_m`` (k, 7) are east, north, radius and the cosine and sine of 2 and 3 times the angle at the knots. Written are
    the horizontal distance (n,) from the surface, the arc length (n,) around the axis and the mean radius (n,).
    """
    last = len(values_m) - 2
    at = np.empty(values_m.shape[1])
    for i in range(len(points_m)):
        place = (points_m[i, 2] - low_m) / step_m
        knot = min(max(int(place), 0), last)
        upper = min(max(place - knot, 0.0), 1.0)
        for k in range(len(at)):
            at[k] = values_m[knot, k] + upper * (values_m[knot + 1, k] - values_m[knot, k])
        east, north = points_m[i, 0] - at[0], points_m[i, 1] - at[1]
        distance = max(np.hypot(east, north), NEAREST_M)
        c, s = east / distance, north / distance
        c2, s2 = c * c - s * s, 2.0 * c * s
        c3, s3 = c2 * c - s2 * s, s2 * c + c2 * s
        off_m[i] = distance - (at[2] + c2 * at[3] + s2 * at[4] + c3 * at[5] + s3 * at[6])
        radius_m[i] = at[2]
        around_m[i] = np.arctan2(s, c) * at[2]


@compiled
def _cube(points_m: NDArray[np.float64], row: int, low_m: NDArray[np.float64], voxel_m: float) -> Cube:
    return (
        int(np.floor((points_m[row, 0] - low_m[0]) / voxel_m)),
        int(np.floor((points_m[row, 1] - low_m[1]) / voxel_m)),
        int(np.floor((points_m[row, 2] - low_m[2]) / voxel_m)),
    )


@compiled
def mark_first(
    points_m: NDArray[np.float64],
    rows: NDArray[np.int64],
    low_m: NDArray[np.float64],
    voxel_m: float,
    table: NDArray[np.int64],
    first: NDArray[np.bool_],
) -> None:
    """Mark in ``first`` (n,) which of some rows of points (n, 3) are the first of their cube of ``voxel_m`` from ``low_m``.

    ``table`` (a power of two,) is room for one row a cube, all EMPTY, at least twice as long as there are rows.
    """
    mask = len(table) - 1
    for row in rows:
        cube = _cube(points_m, row, low_m, voxel_m)
        mixed = cube[0] * 0x2545F491 + cube[1] * 0x9E3779B1 + cube[2] * 0x85EBCA6B
        place = (mixed ^ (mixed >> 21)) & mask
        while table[place] != EMPTY and _cube(points_m, table[place], low_m, voxel_m) != cube:
            place = (place + 1) & mask
        if table[place] == EMPTY:
            table[place] = row
            first[row] = True
