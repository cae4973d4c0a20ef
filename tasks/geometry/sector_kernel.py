"""Which of even sectors directions lie in, without their angles: compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

PIECES: Final = 4096
"""Pieces of the square |x| + |y| = 1. No two edges of up to 1,000 sectors lie in one."""

NEAR: Final = 1e-12
"""A direction as near to an edge as this is decided by its angle, as all others would be."""

TINY: Final = float(np.finfo(np.float64).tiny)

Sectors = tuple[NDArray[np.int64], NDArray[np.float64]]
"""Sector (PIECES,) in which each piece begins, and the directions (sectors + 1, 2) in which sectors begin."""


@compiled
def even_sectors(n_sectors: int) -> Sectors:
    """Sectors from (1, 0) on, towards (0, 1)."""
    edges = np.empty((n_sectors + 1, 2))
    for number in range(n_sectors + 1):
        turn = 2.0 * np.pi * number / n_sectors
        edges[number, 0], edges[number, 1] = np.cos(turn), np.sin(turn)
    first = np.zeros(PIECES, dtype=np.int64)
    for piece in range(1, PIECES):
        along = 4.0 * piece / PIECES
        if along <= 2.0:
            turn = np.arctan2(1.0 - abs(1.0 - along), 1.0 - along)
        else:
            turn = np.arctan2(abs(3.0 - along) - 1.0, along - 3.0) + 2.0 * np.pi
        # an edge at the very begin of a piece is one within it
        first[piece] = int(turn * (n_sectors / (2.0 * np.pi)) - 1e-9)
    return first, edges


@compiled
def find_sectors(
    x: NDArray[np.float64], y: NDArray[np.float64], sectors: Sectors, found: NDArray[np.int64]
) -> None:
    """Sectors (n,) of directions (x, y) of any length: floor(atan2(y, x) / width), as far as float64 tells."""
    first, edges = sectors
    n_sectors = len(edges) - 1
    for i in range(len(x)):
        length = max(abs(x[i]) + abs(y[i]), TINY)
        share = x[i] / length
        along = 1.0 - share if y[i] >= 0.0 else 3.0 + share
        found[i] = min(max(int(along * (PIECES / 4.0)), 0), PIECES - 1)
    for i in range(len(x)):
        sector = first[found[i]]
        before = edges[sector, 0] * y[i] - edges[sector, 1] * x[i]
        beyond = edges[sector + 1, 0] * y[i] - edges[sector + 1, 1] * x[i]
        if min(abs(before), abs(beyond)) <= NEAR * (abs(x[i]) + abs(y[i])):
            sector = int(np.floor(np.arctan2(y[i], x[i]) * (n_sectors / (2.0 * np.pi)))) % n_sectors
        elif beyond > 0.0:
            sector = sector + 1 if sector + 1 < n_sectors else 0
        found[i] = sector
