"""The loops that sort points into cubes and take the covariance of each point's nearest neighbours, compiled."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled
from tasks.geometry.voxel_kernel import EMPTY, FIRST_SIZE, key_of, open_table, slot_of

Arrays = tuple[NDArray[np.int64], NDArray[np.int64]]


@compiled
def _doubled(keys: NDArray[np.int64], numbers: NDArray[np.int64]) -> Arrays:
    """Move a table to one twice as long."""
    longer = open_table(2 * len(keys))
    moved = np.empty(len(longer), np.int64)
    for k in range(len(keys)):
        if keys[k] != EMPTY:
            slot = slot_of(longer, keys[k])
            longer[slot] = keys[k]
            moved[slot] = numbers[k]
    return longer, moved


@compiled
def sort_into_cubes(
    points_m: NDArray[np.float64], low_m: NDArray[np.float64], edge_m: float
) -> tuple[Arrays, Arrays]:
    """Sort points (n, 3) into cubes: the keys of these in an open table, with their numbers; then two arrays more.

    These are the order (n,) of the points cube by cube, within one as they came, and where in it each cube starts (c + 1,).
    """
    keys, numbers = open_table(FIRST_SIZE), np.empty(FIRST_SIZE, np.int64)
    cube = np.empty(len(points_m), np.int64)
    n_cubes = 0
    for i in range(len(points_m)):
        # one cube is kept free below, so that neighbours of the first need no question
        key = key_of(
            int(np.floor((points_m[i, 0] - low_m[0]) / edge_m)) + 1,
            int(np.floor((points_m[i, 1] - low_m[1]) / edge_m)) + 1,
            int(np.floor((points_m[i, 2] - low_m[2]) / edge_m)) + 1,
        )
        slot = slot_of(keys, key)
        if keys[slot] == EMPTY:
            keys[slot], numbers[slot] = key, n_cubes
            cube[i] = n_cubes
            n_cubes += 1
            if 2 * n_cubes > len(keys):
                keys, numbers = _doubled(keys, numbers)
        else:
            cube[i] = numbers[slot]
    begins = np.zeros(n_cubes + 1, np.int64)
    for i in range(len(cube)):
        begins[cube[i] + 1] += 1
    begins = np.cumsum(begins)
    place, order = begins[:-1].copy(), np.empty(len(cube), np.int64)
    for i in range(len(cube)):
        order[place[cube[i]]] = i
        place[cube[i]] += 1
    return (keys, numbers), (order, begins)


@compiled
def _insert(away: NDArray[np.float64], who: NDArray[np.int64], n: int, squared: float, index: int) -> int:
    """Keep the nearest in order of distance, equal ones by index; give how many there are."""
    if n == len(away):
        if squared > away[n - 1] or (squared == away[n - 1] and index > who[n - 1]):
            return n
        n -= 1
    k = n
    while k > 0 and (away[k - 1] > squared or (away[k - 1] == squared and who[k - 1] > index)):
        away[k] = away[k - 1]
        who[k] = who[k - 1]
        k -= 1
    away[k] = squared
    who[k] = index
    return n + 1


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
    for m in range(n):
        dx, dy, dz = points_m[who[m], 0] - x, points_m[who[m], 1] - y, points_m[who[m], 2] - z
        squares[0, 0] += dx * dx
        squares[0, 1] += dx * dy
        squares[0, 2] += dx * dz
        squares[1, 1] += dy * dy
        squares[1, 2] += dy * dz
        squares[2, 2] += dz * dz
    squares[1, 0], squares[2, 0], squares[2, 1] = squares[0, 1], squares[0, 2], squares[1, 2]


@compiled
def _beside(
    point_m: NDArray[np.float64],
    low_m: NDArray[np.float64],
    edge_m: float,
    table: Arrays,
    begins: NDArray[np.int64],
    ranges: NDArray[np.int64],
) -> tuple[int, int]:
    """Parts of the order in a point's cube and those beside it, to ``ranges`` (27, 2); how many, of how many points."""
    keys, numbers = table
    i = int(np.floor((point_m[0] - low_m[0]) / edge_m))
    j = int(np.floor((point_m[1] - low_m[1]) / edge_m))
    k = int(np.floor((point_m[2] - low_m[2]) / edge_m))
    n = n_points = 0
    for beside in range(27):
        slot = slot_of(keys, key_of(i + beside // 9, j + beside // 3 % 3, k + beside % 3))
        if keys[slot] != EMPTY:
            ranges[n, 0], ranges[n, 1] = begins[numbers[slot]], begins[numbers[slot] + 1]
            n_points += ranges[n, 1] - ranges[n, 0]
            n += 1
    return n, n_points


@compiled
def _nearest(
    sorted_m: NDArray[np.float64],
    here: int,
    ranges: NDArray[np.int64],
    squared_radius: float,
    away: NDArray[np.float64],
    who: NDArray[np.int64],
) -> int:
    """Find the nearest in the ranges to a point, both by their place in the order; give how many there are."""
    x, y, z = sorted_m[here, 0], sorted_m[here, 1], sorted_m[here, 2]
    n, most = 0, len(away)
    for r in range(len(ranges)):
        for m in range(ranges[r, 0], ranges[r, 1]):
            dx, dy, dz = sorted_m[m, 0] - x, sorted_m[m, 1] - y, sorted_m[m, 2] - z
            squared = dx * dx + dy * dy + dz * dz
            if squared < squared_radius and (n < most or squared <= away[n - 1]):
                n = _insert(away, who, n, squared, m)
    return n


@compiled
def squares_around(  # noqa: PLR0913, PLR0917 - a compiled loop
    points_m: NDArray[np.float64],
    row_of: NDArray[np.int64],
    low_m: NDArray[np.float64],
    radius_m: float,
    few: tuple[int, int],
    table: Arrays,
    cubes: Arrays,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Number (k,) and sums of squares (k, 3, 3) of the nearest points around some, nearer than the radius.

    ``row_of`` (n,) says where the result of a point goes, -1 for those that are not asked. ``few`` are the least and the
    most neighbours that count; with fewer nothing is summed. ``table`` and ``cubes`` are what ``sort_into_cubes``
    gives for cubes as wide as the radius.
    """
    order, begins = cubes
    least, most = few
    n_rows = np.max(row_of) + 1
    sorted_m = points_m[order]
    count, squares = np.zeros(n_rows, np.int64), np.zeros((n_rows, 3, 3))
    away, who, ranges = np.empty(most), np.empty(most, np.int64), np.empty((27, 2), np.int64)
    for cube in range(len(begins) - 1):
        n_ranges = -1
        n_points = 0
        for m in range(begins[cube], begins[cube + 1]):
            row = row_of[order[m]]
            if row < 0:
                continue
            if n_ranges < 0:
                n_ranges, n_points = _beside(sorted_m[m], low_m, radius_m, table, begins, ranges)
            if n_points < least:
                continue
            count[row] = _nearest(sorted_m, m, ranges[:n_ranges], radius_m * radius_m, away, who)
            if count[row] >= least:
                _squares(sorted_m, who, count[row], squares[row])
    return count, squares
