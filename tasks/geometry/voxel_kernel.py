"""The loops over all points that find the occupied cubes of a grid, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

AXIS_BITS: Final = 21
"""Cubes along an axis in a key: 2**21."""

EMPTY: Final = -1
FIRST_SIZE: Final = 1 << 14
"""Of a table, at least; it is doubled whenever it is half full."""

POINTS_A_PLACE: Final = 2
"""Of a cloud for each place of its first table, at least: doubling costs more than a table that is too large."""

SPREAD: Final = 0x9E3779B97F4A7C15 - (1 << 64)
"""2**64 over the golden ratio: its product with keys that lie side by side lies all over the table."""


@compiled
def key_of(i: int, j: int, k: int) -> int:
    """One number for a cube (each index from 0 to 2**21 - 1)."""
    return (i << (2 * AXIS_BITS)) | (j << AXIS_BITS) | k


@compiled
def slot_of(keys: NDArray[np.int64], key: int) -> int:
    """Where a key stands in an open table, or the free place where it belongs; the length is a power of two."""
    mask = len(keys) - 1
    mixed = key * SPREAD
    slot = (mixed ^ (mixed >> 29)) & mask
    while keys[slot] != EMPTY and keys[slot] != key:
        slot = (slot + 1) & mask
    return slot


@compiled
def bounds(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lowest and highest coordinates (2, 3) of points (n, 3), n > 0."""
    found = np.empty((2, 3))
    for axis in range(3):
        found[0, axis] = found[1, axis] = points_m[0, axis]
    for i in range(1, len(points_m)):
        for axis in range(3):
            value = points_m[i, axis]
            found[0, axis] = min(found[0, axis], value)
            found[1, axis] = max(found[1, axis], value)
    return found


@compiled
def open_table(size: int) -> NDArray[np.int64]:
    """Give an empty table; the size is a power of two."""
    return np.full(size, EMPTY, np.int64)


@compiled
def first_of_cubes(
    points_m: NDArray[np.float64], low_m: NDArray[np.float64], edge_m: float
) -> NDArray[np.bool_]:
    """Whether each of the points (n, 3) is the first in its cube."""
    size = FIRST_SIZE
    while POINTS_A_PLACE * size < len(points_m):
        size *= 2
    keys, n_cubes = open_table(size), 0
    is_first = np.zeros(len(points_m), np.bool_)
    for i in range(len(points_m)):
        key = key_of(
            int(np.floor((points_m[i, 0] - low_m[0]) / edge_m)),
            int(np.floor((points_m[i, 1] - low_m[1]) / edge_m)),
            int(np.floor((points_m[i, 2] - low_m[2]) / edge_m)),
        )
        slot = slot_of(keys, key)
        if keys[slot] == key:
            continue
        is_first[i] = True
        keys[slot] = key
        n_cubes += 1
        if 2 * n_cubes > len(keys):
            smaller = keys
            keys = open_table(2 * len(smaller))
            for k in range(len(smaller)):
                if smaller[k] != EMPTY:
                    keys[slot_of(keys, smaller[k])] = smaller[k]
    return is_first
