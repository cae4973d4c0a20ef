"""The loop over all points of a shaft that sums them up in cells, compiled.

Points are taken ``BLOCK`` at once, each step in a loop of its own: the processor then works on several points at a time.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled
from tasks.geometry.sector_kernel import Sectors, even_sectors, find_sectors

SUMS: Final = 10
"""Points, points used, weight, weighted residual, cosine, sine, height and foot, squared residuals used, robust weight."""

MOMENTS: Final = 3
"""Squared influence in sigmas, slope of the influence, robust weight: sums over all points."""

BLOCK: Final = 512

SEEN: Final = 8
"""Of each point of a block: east and north of the axis, residual, cosine, sine, foot, share of the table's row, sigma."""

WEIGHED: Final = 5
"""Robust weight, weight, squared influence in sigmas, slope of the influence, and 1 for a point that counts."""

Place = tuple[float, float]
"""Lowest height and step."""

CellGrid = tuple[float, float, int, NDArray[np.float64]]
"""Cells: lowest height, step, number of heights, and the noise (stations, sectors) of their points, metres."""

TINY: Final = float(np.finfo(np.float64).tiny)


@compiled
def _off_axis(
    points_m: NDArray[np.float64],
    origin_m: NDArray[np.float64],
    table: NDArray[np.float64],
    place: Place,
    rows: NDArray[np.int64],
    seen: NDArray[np.float64],
) -> None:
    """Where points are from the axis at their own height, and its row and share in the table."""
    last = len(table) - 2
    for i in range(len(points_m)):
        at = (points_m[i, 2] - place[0]) / place[1]
        row = min(max(int(at), 0), last)
        share = at - row
        seen[0, i] = (
            points_m[i, 0] - origin_m[0] - (table[row, 0] + share * (table[row + 1, 0] - table[row, 0]))
        )
        seen[1, i] = (
            points_m[i, 1] - origin_m[1] - (table[row, 1] + share * (table[row + 1, 1] - table[row, 1]))
        )
        rows[i], seen[6, i] = row, share


@compiled
def _see_level(points_m: NDArray[np.float64], seen: NDArray[np.float64]) -> None:
    """Distances in the horizontal and the directions."""
    for i in range(len(points_m)):
        distance = max(np.sqrt(seen[0, i] * seen[0, i] + seen[1, i] * seen[1, i]), TINY)
        seen[2, i], seen[5, i] = distance, points_m[i, 2]
        seen[3, i], seen[4, i] = seen[0, i] / distance, seen[1, i] / distance


@compiled
def _see_across(
    points_m: NDArray[np.float64],
    table: NDArray[np.float64],
    place: Place,
    rows: NDArray[np.int64],
    seen: NDArray[np.float64],
) -> None:
    """Distances across the axis and the directions; the foot on the axis, and its row and share in the table."""
    last = len(table) - 2
    for i in range(len(points_m)):
        row, share, de, dn = rows[i], seen[6, i], seen[0, i], seen[1, i]
        slope_e = table[row, 3] + share * (table[row + 1, 3] - table[row, 3])
        slope_n = table[row, 4] + share * (table[row + 1, 4] - table[row, 4])
        length = 1.0 + slope_e**2 + slope_n**2
        along = de * slope_e + dn * slope_n
        seen[2, i] = np.sqrt(max(de * de + dn * dn - along**2 / length, TINY))
        foot = points_m[i, 2] + along / length
        at = (foot - place[0]) / place[1]
        rows[i] = min(max(int(at), 0), last)
        seen[5, i], seen[6, i] = foot, at - rows[i]
        de, dn = de - along * slope_e / length, dn - along * slope_n / length
        left = max(np.sqrt(de * de + dn * dn), TINY)
        seen[3, i], seen[4, i] = de / left, dn / left


@compiled
def _take_surface_off(
    n: int,
    table: NDArray[np.float64],
    harmonics: NDArray[np.float64],
    rows: NDArray[np.int64],
    seen: NDArray[np.float64],
    turned: NDArray[np.float64],
) -> None:
    """Turn distances into residuals; ``harmonics`` (k, 2, rows) are real and imaginary parts, ``turned`` (2, n) is used."""
    for i in range(n):
        row, share = rows[i], seen[6, i]
        seen[2, i] -= table[row, 2] + share * (table[row + 1, 2] - table[row, 2])
        turned[0, i], turned[1, i] = seen[3, i], seen[4, i]
    for k in range(len(harmonics)):
        real, imaginary = harmonics[k, 0], harmonics[k, 1]
        for i in range(n):
            row, share, c, s = rows[i], seen[6, i], seen[3, i], seen[4, i]
            tc = turned[0, i] * c - turned[1, i] * s
            ts = turned[0, i] * s + turned[1, i] * c
            seen[2, i] -= (real[row] + share * (real[row + 1] - real[row])) * tc
            seen[2, i] += (imaginary[row] + share * (imaginary[row + 1] - imaginary[row])) * ts
            turned[0, i], turned[1, i] = tc, ts


@compiled
def _find_cells(
    points_m: NDArray[np.float64],
    station: NDArray[np.uint16],
    sectors: Sectors,
    grid: CellGrid,
    seen: NDArray[np.float64],
    cells: NDArray[np.int64],
) -> None:
    """Number of the cell of each point, and its sigma."""
    n = len(points_m)
    low, step, n_heights, sigma_m = grid
    n_sectors = sigma_m.shape[1]
    find_sectors(seen[3, :n], seen[4, :n], sectors, cells)
    for i in range(n):
        seen[7, i] = sigma_m[station[i], cells[i]]
    for i in range(n):
        height = int(min(max(0.0, (points_m[i, 2] - low) / step), n_heights - 1.0))  # 0 for no number
        cells[i] += (np.int64(station[i]) * n_heights + height) * n_sectors


@compiled
def _weigh(n: int, cut: float, seen: NDArray[np.float64], weighed: NDArray[np.float64]) -> None:
    """Tukey's biweight of n points (WEIGHED, n)."""
    for i in range(n):
        scaled = (seen[2, i] / seen[7, i]) ** 2
        ratio = min(scaled / cut**2, 1.0)
        robust = (1.0 - ratio) ** 2
        weighed[0, i], weighed[1, i] = robust, robust / seen[7, i] ** 2
        weighed[2, i], weighed[3, i] = robust**2 * scaled, (1.0 - ratio) * (1.0 - 5.0 * ratio)
        weighed[4, i] = 1.0 if ratio < 1.0 else 0.0


@compiled
def _add(
    points_m: NDArray[np.float64],
    seen: NDArray[np.float64],
    weighed: NDArray[np.float64],
    cells: NDArray[np.int64],
    sums: NDArray[np.float64],
    moments: NDArray[np.float64],
) -> None:
    """Add weighed points to their cells (cells, SUMS) and to the moments."""
    influence, slope, all_robust = 0.0, 0.0, 0.0
    for i in range(len(points_m)):
        cell = sums[cells[i]]
        residual, weight, used = seen[2, i], weighed[1, i], weighed[4, i]
        cell[0] += 1.0
        cell[1] += used
        cell[2] += weight
        cell[3] += weight * residual
        cell[4] += weight * seen[3, i]
        cell[5] += weight * seen[4, i]
        cell[6] += weight * points_m[i, 2]
        cell[7] += weight * seen[5, i]
        cell[8] += used * residual**2
        cell[9] += weighed[0, i]
        influence += weighed[2, i]
        slope += weighed[3, i]
        all_robust += weighed[0, i]
    moments[0] += influence
    moments[1] += slope
    moments[2] += all_robust


@compiled
def add_points(  # noqa: PLR0913, PLR0917 - a compiled loop
    points_m: NDArray[np.float64],
    station: NDArray[np.uint16],
    origin_m: NDArray[np.float64],
    table: NDArray[np.float64],
    harmonics: NDArray[np.float64],
    place: Place,
    across: bool,
    grid: CellGrid,
    cut: float,
    sums: NDArray[np.float64],
    moments: NDArray[np.float64],
) -> None:
    """Add points (n, 3) of stations (n,) to ``sums`` (cells, SUMS) and ``moments`` (MOMENTS,).

    ``table`` (rows, 5) is the surface by height: axis east and north about ``origin_m``, radius, slopes; ``harmonics``
    (k, 2, rows) what its sections are off the circle, real and imaginary; ``place`` its lowest height and step. Cells
    stand in the order of stations, heights and sectors. ``cut`` is where Tukey's biweight ends, in sigmas.
    """
    sectors = even_sectors(grid[3].shape[1])
    rows, cells = np.empty(BLOCK, dtype=np.int64), np.empty(BLOCK, dtype=np.int64)
    seen, turned, weighed = np.empty((SEEN, BLOCK)), np.empty((2, BLOCK)), np.empty((WEIGHED, BLOCK))
    for begin in range(0, len(points_m), BLOCK):
        block, own = points_m[begin : begin + BLOCK], station[begin : begin + BLOCK]
        _off_axis(block, origin_m, table, place, rows, seen)
        if across:
            _see_across(block, table, place, rows, seen)
        else:
            _see_level(block, seen)
        _take_surface_off(len(block), table, harmonics, rows, seen, turned)
        _find_cells(block, own, sectors, grid, seen, cells)
        _weigh(len(block), cut, seen, weighed)
        _add(block, seen, weighed, cells, sums, moments)
