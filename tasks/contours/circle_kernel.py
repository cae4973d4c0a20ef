"""The loops over the points of a slice that adjust a circle, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled
from tasks.geometry.median_kernel import median_in_place

BLOCK: Final = 512
"""Points that are worked on at once."""

SUMS: Final = 10
"""Normal matrix (east east, east north, east radius, north north, north radius, radius radius), right side (3), cost."""

TINY: Final = float(np.finfo(np.float64).tiny)

Points = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""East, north and widening (n,) of the points of a slice, and their relative sigma (n,), or (0,) where all are alike."""

Round = tuple[float, float, float]
"""East, north and radius of a circle."""


@compiled
def _look(points: Points, begin: int, end: int, circle: Round, seen: NDArray[np.float64]) -> None:
    """Residuals of points begin to end, and derivatives by east and north: (3, end - begin)."""
    x, y, widening, _ = points
    for i in range(begin, end):
        east, north = circle[0] - x[i], circle[1] - y[i]
        distance = np.sqrt(east * east + north * north)
        # at the centre itself no direction is better than another: 0 / tiny leaves the point without a say
        length = max(distance, TINY)
        seen[0, i - begin] = distance - widening[i] - circle[2]
        seen[1, i - begin], seen[2, i - begin] = east / length, north / length


@compiled
def _weigh(
    residual: NDArray[np.float64], sigma: NDArray[np.float64], cut: float, weighed: NDArray[np.float64]
) -> None:
    """Weights of points and what they cost (2, n): Tukey's biweight within ``cut``, squares where it is infinite."""
    n = len(residual)
    weighed[0, :n], weighed[1, :n] = 1.0, residual
    for i in range(len(sigma)):
        each = max(sigma[i], TINY)
        weighed[0, i], weighed[1, i] = 1.0 / (each * each), residual[i] / each
    if cut == np.inf:
        for i in range(n):
            weighed[1, i] *= weighed[1, i]
        return
    per_cut = 1.0 / cut
    for i in range(n):
        u = weighed[1, i] * per_cut
        inside = max(1.0 - u * u, 0.0)
        weighed[0, i] *= inside * inside
        weighed[1, i] = 1.0 - inside * inside * inside


@compiled
def sum_circle(points: Points, circle: Round, cut: float) -> NDArray[np.float64]:
    """Normal equations and cost (SUMS,) of the points of a slice at a circle."""
    sums, seen, weighed = np.zeros(SUMS), np.empty((3, BLOCK)), np.empty((2, BLOCK))
    n = len(points[0])
    for begin in range(0, n, BLOCK):
        end = min(begin + BLOCK, n)
        _look(points, begin, end, circle, seen)
        _weigh(seen[0, : end - begin], points[3][begin:end], cut, weighed)
        sums += _added(end - begin, seen, weighed)
    if cut < np.inf:
        sums[9] *= cut * cut / 3.0
    return sums


@compiled
def _added(n: int, seen: NDArray[np.float64], weighed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sums (SUMS,) of n weighed points."""
    ee = en = nn = e = north = one = re = rn = r = cost = 0.0
    for i in range(n):
        weight, residual = weighed[0, i], seen[0, i]
        by_east, by_north = weight * seen[1, i], weight * seen[2, i]
        ee += by_east * seen[1, i]
        en += by_east * seen[2, i]
        nn += by_north * seen[2, i]
        e += by_east
        north += by_north
        one += weight
        re += by_east * residual
        rn += by_north * residual
        r += weight * residual
        cost += weighed[1, i]
    return np.array([ee, en, -e, nn, -north, one, re, rn, -r, cost])


@compiled
def sum_used(points: Points, circle: Round, used: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Normal equations (SUMS,) of the points that are used, without robust weights; their cost is the sum of squares."""
    sums, seen, weighed = np.zeros(SUMS), np.empty((3, BLOCK)), np.empty((2, BLOCK))
    n = len(points[0])
    for begin in range(0, n, BLOCK):
        end = min(begin + BLOCK, n)
        _look(points, begin, end, circle, seen)
        _weigh(seen[0, : end - begin], points[3][begin:end], np.inf, weighed)
        for i in range(begin, end):
            if not used[i]:
                weighed[0, i - begin] = weighed[1, i - begin] = 0.0
        sums += _added(end - begin, seen, weighed)
    return sums


@compiled
def nearest_circle(points: Points, centers: NDArray[np.float64]) -> Round:
    """Of circles about centres (k, 2), each with its median radius, the one with the least median distance."""
    x, y, widening, _ = points
    n = len(x)
    distance, scratch = np.empty(n), np.empty(n)
    best, least, radius_of_best = 0, np.inf, np.nan
    for k in range(len(centers)):
        east, north = centers[k, 0], centers[k, 1]
        for i in range(n):
            distance[i] = np.sqrt((x[i] - east) ** 2 + (y[i] - north) ** 2) - widening[i]
        scratch[:] = distance
        radius = median_in_place(scratch)
        nearer = 0
        for i in range(n):
            scratch[i] = abs(distance[i] - radius)
            nearer += scratch[i] < least
        # with less than half of the points nearer than those of the best one its median cannot be less
        if nearer > (n - 1) // 2:
            median = median_in_place(scratch)
            if median < least:
                best, least, radius_of_best = k, median, radius
    return centers[best, 0], centers[best, 1], radius_of_best
