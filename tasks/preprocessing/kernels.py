"""The loops over all points of a cloud that isolating a shaft needs, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

NEAREST_M: Final = 1e-9
"""A point on the axis has no direction; nearer ones count as that far."""

EMPTY: Final = -1

Cube = tuple[int, int, int]

Seen = tuple[float, float, float, float, float]
"""Distance, cosine, sine, mean radius, and what the section is off the circle."""


@compiled
def gate_points(  # noqa: PLR0913, PLR0917 - a compiled loop
    points_m: NDArray[np.float64],
    low_m: float,
    high_m: float,
    east_m: float,
    north_m: float,
    within2_m2: float,
    codes: tuple[int, int, int],
    code: NDArray[np.uint8],
) -> None:
    """Write the first of ``codes`` for points (n, 3) not between two heights, the second for those far from a position.

    The third is for those that stay; far is what is not within a distance, of which the square is given.
    """
    for i in range(len(points_m)):
        z = points_m[i, 2]
        if not low_m <= z <= high_m:
            code[i] = codes[0]
            continue
        east, north = points_m[i, 0] - east_m, points_m[i, 1] - north_m
        code[i] = codes[2] if east * east + north * north <= within2_m2 else codes[1]


@compiled
def _direction(
    points_m: NDArray[np.float64], row: int, low_m: float, step_m: float, values_m: NDArray[np.float64]
) -> Seen:
    """Distance of a point from the axis, cosine and sine of its direction, mean radius there, and what is off the circle."""
    place = (points_m[row, 2] - low_m) / step_m
    knot = min(max(int(place), 0), len(values_m) - 2)
    upper = min(max(place - knot, 0.0), 1.0)
    low, high = values_m[knot], values_m[knot + 1]
    east = points_m[row, 0] - (low[0] + upper * (high[0] - low[0]))
    north = points_m[row, 1] - (low[1] + upper * (high[1] - low[1]))
    distance = max(np.sqrt(east * east + north * north), NEAREST_M)
    c, s = east / distance, north / distance
    c2, s2 = c * c - s * s, 2.0 * c * s
    c3, s3 = c2 * c - s2 * s, s2 * c + c2 * s
    lobes = c2 * (low[3] + upper * (high[3] - low[3])) + s2 * (low[4] + upper * (high[4] - low[4]))
    lobes += c3 * (low[5] + upper * (high[5] - low[5])) + s3 * (low[6] + upper * (high[6] - low[6]))
    return distance, c, s, low[2] + upper * (high[2] - low[2]), lobes


@compiled
def measure_points(
    points_m: NDArray[np.float64],
    low_m: float,
    step_m: float,
    values_m: NDArray[np.float64],
    off_m: NDArray[np.float64],
    radius_m: NDArray[np.float64],
) -> None:
    """Measure points (n, 3) from a surface with knots every ``step_m`` from ``low_m`` on.

    ``values_m`` (k, 7) are east, north, radius and the cosine and sine of 2 and 3 times the angle at the knots. Written are
    the horizontal distance (n,) from the surface and the mean radius (n,).
    """
    for i in range(len(points_m)):
        distance, _, _, radius, lobes = _direction(points_m, i, low_m, step_m, values_m)
        off_m[i] = distance - (radius + lobes)
        radius_m[i] = radius


@compiled
def unroll_points(
    points_m: NDArray[np.float64],
    low_m: float,
    step_m: float,
    values_m: NDArray[np.float64],
    around_m: NDArray[np.float64],
) -> None:
    """Write the arc length (n,) around the axis of that surface at which points (n, 3) lie."""
    for i in range(len(points_m)):
        _, c, s, radius, _ = _direction(points_m, i, low_m, step_m, values_m)
        around_m[i] = np.arctan2(s, c) * radius


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
    rows: NDArray[np.int32],
    low_m: NDArray[np.float64],
    voxel_m: float,
    table: NDArray[np.int32],
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
