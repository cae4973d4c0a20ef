"""The loops that sort points into cubes and take the covariance of each point's nearest neighbours, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

DIGIT: Final = 11
"""Bits of a number that are sorted in one go."""

COLUMNS: Final = 9
"""Of cubes along the third axis: that of a point, and those beside it."""

Cubes = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]


@compiled
def _sort_by_digit(
    numbers: NDArray[np.int64],
    order: NDArray[np.int64],
    shift: int,
    to_numbers: NDArray[np.int64],
    to_order: NDArray[np.int64],
) -> None:
    """Sort numbers (n,) and what goes with them by one digit, equal ones as they come."""
    begins, mask = np.zeros((1 << DIGIT) + 1, np.int64), (1 << DIGIT) - 1
    for i in range(len(numbers)):
        begins[((numbers[i] >> shift) & mask) + 1] += 1
    for digit in range(1 << DIGIT):
        begins[digit + 1] += begins[digit]
    for i in range(len(numbers)):
        digit = (numbers[i] >> shift) & mask
        to_numbers[begins[digit]], to_order[begins[digit]] = numbers[i], order[i]
        begins[digit] += 1


@compiled
def sort_into_cubes(
    points_m: NDArray[np.float64], low_m: NDArray[np.float64], edge_m: float, shape: NDArray[np.int64]
) -> Cubes:
    """Sort points (n, 3) into the cubes of a grid of some shape (3,), whose outermost cubes are kept free.

    Gives the numbers (c,) of the cubes that are not empty, ascending; the order (n,) of the points cube by cube, within one
    as they come; and where in it each cube starts (c + 1,).
    """
    n = len(points_m)
    cube, order = np.empty(n, np.int64), np.arange(n)
    for i in range(n):
        cube[i] = int(np.floor((points_m[i, 0] - low_m[0]) / edge_m)) + 1
        cube[i] = cube[i] * shape[1] + int(np.floor((points_m[i, 1] - low_m[1]) / edge_m)) + 1
        cube[i] = cube[i] * shape[2] + int(np.floor((points_m[i, 2] - low_m[2]) / edge_m)) + 1
    to_cube, to_order = np.empty(n, np.int64), np.empty(n, np.int64)
    shift, largest = 0, shape[0] * shape[1] * shape[2] - 1
    while largest > 0:
        _sort_by_digit(cube, order, shift, to_cube, to_order)
        cube, order, to_cube, to_order = to_cube, to_order, cube, order
        shift += DIGIT
        largest >>= DIGIT
    begins, n_cubes = np.empty(n + 1, np.int64), 0
    for i in range(n):
        if i == 0 or cube[i] != cube[i - 1]:
            begins[n_cubes] = i
            n_cubes += 1
    begins[n_cubes] = n
    return cube[begins[:n_cubes]], order, begins[: n_cubes + 1].copy()


@compiled
def _columns_beside(shape: NDArray[np.int64]) -> NDArray[np.int64]:
    """How much the number of a cube changes from a column of cubes to itself and those beside it (9,), ascending."""
    steps = np.empty(COLUMNS, np.int64)
    for column in range(COLUMNS):
        steps[column] = ((column // 3 - 1) * shape[1] + column % 3 - 1) * shape[2]
    return steps


@compiled
def _ranges_around(
    cube: int, cubes: Cubes, steps: NDArray[np.int64], at: NDArray[np.int64], ranges: NDArray[np.int64]
) -> int:
    """Parts of the order that lie in a cube and the 26 around it, to ``ranges`` (9, 2); give how many points that are.

    ``at`` (9,) says where each column of cubes was left: cubes are asked for one after the other, ascending.
    """
    numbers, _, begins = cubes
    n_points = 0
    for column in range(COLUMNS):
        first, k = cube + steps[column] - 1, at[column]
        while k < len(numbers) and numbers[k] < first:
            k += 1
        at[column] = k
        ranges[column, 0] = begins[k]
        while k < len(numbers) and numbers[k] <= first + 2:
            k += 1
        ranges[column, 1] = begins[k]
        n_points += ranges[column, 1] - ranges[column, 0]
    return n_points


@compiled
def _within(
    sorted_m: NDArray[np.float64],
    here: int,
    ranges: NDArray[np.int64],
    squared_radius: float,
    away: NDArray[np.float64],
    who: NDArray[np.int64],
) -> int:
    """Find all points in the ranges that are nearer than a radius to a point, itself with them; give how many."""
    x, y, z = sorted_m[here, 0], sorted_m[here, 1], sorted_m[here, 2]
    n = 0
    for r in range(len(ranges)):
        for m in range(ranges[r, 0], ranges[r, 1]):
            dx, dy, dz = sorted_m[m, 0] - x, sorted_m[m, 1] - y, sorted_m[m, 2] - z
            # written down whether or not it is near, and overwritten if not: a guess less for the processor
            away[n], who[n] = dx * dx + dy * dy + dz * dz, m
            n += away[n] < squared_radius
    return n


@compiled
def _keep_nearest(
    away: NDArray[np.float64], who: NDArray[np.int64], n: int, most: int, order: NDArray[np.int64]
) -> int:
    """Bring the nearest of n points to the front, of those equally far the first in the cloud; give how many are kept."""
    if n <= most:
        return n
    for m in range(n):
        squared, index = away[m], who[m]
        k = min(m, most)
        if k == most and (
            squared > away[k - 1] or (squared == away[k - 1] and order[index] > order[who[k - 1]])
        ):
            continue
        k -= k == most
        while k > 0 and (
            away[k - 1] > squared or (away[k - 1] == squared and order[who[k - 1]] > order[index])
        ):
            away[k], who[k] = away[k - 1], who[k - 1]
            k -= 1
        away[k], who[k] = squared, index
    return most


@compiled
def _squares(
    points_m: NDArray[np.float64], who: NDArray[np.int64], n: int, squares: NDArray[np.float64]
) -> None:
    """Sums of squares (3, 3) of some points about their mean."""
    x = y = z = 0.0
    for m in range(n):
        x += points_m[who[m], 0]
        y += points_m[who[m], 1]
        z += points_m[who[m], 2]
    x, y, z = x / n, y / n, z / n
    xx = xy = xz = yy = yz = zz = 0.0
    for m in range(n):
        dx, dy, dz = points_m[who[m], 0] - x, points_m[who[m], 1] - y, points_m[who[m], 2] - z
        xx, xy, xz = xx + dx * dx, xy + dx * dy, xz + dx * dz
        yy, yz, zz = yy + dy * dy, yz + dy * dz, zz + dz * dz
    squares[0, 0], squares[1, 1], squares[2, 2] = xx, yy, zz
    squares[0, 1], squares[0, 2], squares[1, 2] = xy, xz, yz
    squares[1, 0], squares[2, 0], squares[2, 1] = xy, xz, yz


@compiled
def squares_around(
    points_m: NDArray[np.float64],
    row_of: NDArray[np.int64],
    radius_m: float,
    few: tuple[int, int],
    cubes: Cubes,
    shape: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Number (k,) and sums of squares (k, 3, 3) of the nearest points around some, nearer than the radius.

    ``row_of`` (n,) says where the result of a point goes, -1 for those that are not asked. ``few`` are the least and the
    most neighbours that count; with fewer nothing is summed. ``cubes`` are what ``sort_into_cubes`` gives for cubes as
    wide as the radius and the same shape of the grid.
    """
    numbers, order, begins = cubes
    least, most = few
    n_rows = np.max(row_of) + 1
    sorted_m = points_m[order]
    count, squares = np.zeros(n_rows, np.int64), np.zeros((n_rows, 3, 3))
    away, who = np.empty(most), np.empty(most, np.int64)
    steps, at, ranges = _columns_beside(shape), np.zeros(COLUMNS, np.int64), np.empty((COLUMNS, 2), np.int64)
    for cube in range(len(numbers)):
        n_points = _ranges_around(numbers[cube], cubes, steps, at, ranges)
        if n_points < least:
            continue
        if n_points >= len(away):
            away, who = np.empty(2 * n_points), np.empty(2 * n_points, np.int64)
        for m in range(begins[cube], begins[cube + 1]):
            row = row_of[order[m]]
            if row < 0:
                continue
            n = _within(sorted_m, m, ranges, radius_m * radius_m, away, who)
            count[row] = min(n, most)
            if n >= least:
                _squares(sorted_m, who, _keep_nearest(away, who, n, most, order), squares[row])
    return count, squares
