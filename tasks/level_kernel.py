"""The loops over points of the check of levels, compiled."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled
from tasks.geometry.robust_kernel import biweight


@compiled
def count_stations(station: NDArray[np.uint16], n_stations: int) -> NDArray[np.int64]:
    """Points (n_stations,) of every station; those of others do not count."""
    counts = np.zeros(n_stations, dtype=np.int64)
    for i in range(len(station)):
        if 0 <= station[i] < n_stations:
            counts[station[i]] += 1
    return counts


@compiled
def take_places(
    station: NDArray[np.uint16], places: NDArray[np.int64], ends: NDArray[np.int64], rows: NDArray[np.int64]
) -> None:
    """Rows of the points that stand at certain places among those of their station.

    ``places`` ascend for every station; those of station s, and their rows, stand from ``ends[s]`` to ``ends[s + 1]``.
    """
    n_stations = len(ends) - 1
    seen, taken = np.zeros(n_stations, dtype=np.int64), ends[:-1].copy()
    for i in range(len(station)):
        own = station[i]
        if 0 <= own < n_stations:
            if taken[own] < ends[own + 1] and places[taken[own]] == seen[own]:
                rows[taken[own]] = i
                taken[own] += 1
            seen[own] += 1


@compiled
def weigh_rows(
    design: NDArray[np.float64], residual: NDArray[np.float64], error: NDArray[np.float64], reach: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normal matrix (p, p) and right side (p,) of rows (n, p) with Tukey's biweight of their errors up to ``reach``."""
    p = design.shape[1]
    normal, right = np.zeros((p, p)), np.zeros(p)
    for i in range(len(design)):
        weight = biweight(error[i], reach)
        for a in range(p):
            weighted = weight * design[i, a]
            right[a] += weighted * residual[i]
            for b in range(a + 1):
                normal[a, b] += weighted * design[i, b]
    for a in range(p):
        for b in range(a):
            normal[b, a] = normal[a, b]
    return normal, right
