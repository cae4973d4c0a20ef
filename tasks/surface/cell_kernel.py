"""The loop over all points of a shaft that sums them up in cells, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

SUMS: Final = 10
"""Points, points used, weight, weighted residual, cosine, sine, height and foot, squared residuals used, robust weight."""

MOMENTS: Final = 3
"""Squared influence in sigmas, slope of the influence, robust weight: sums over all points."""

Place = tuple[float, float]
"""Lowest height and step."""

Ray = tuple[float, float, float, float, int, float]
"""Distance, cosine and sine, height of the foot, and its row and share in the table."""

Seen = tuple[float, float, float, float, float]
"""Residual, cosine, sine, height and foot."""

TINY: Final = float(np.finfo(np.float64).tiny)


@compiled
def _at(table: NDArray[np.float64], place: float) -> tuple[int, float]:
    row = min(max(int(place), 0), len(table) - 2)
    return row, place - row


@compiled
def _between(table: NDArray[np.float64], row: int, share: float, column: int) -> float:
    low: float = table[row, column]
    high: float = table[row + 1, column]
    return low + share * (high - low)


@compiled
def _seen_across(  # noqa: PLR0913, PLR0917 - a compiled loop
    de: float, dn: float, z: float, row: int, share: float, table: NDArray[np.float64], place: Place
) -> Ray:
    """A point at (de, dn) from the axis at its own height: its distance across the axis, and the foot on it."""
    slope_e, slope_n = _between(table, row, share, 3), _between(table, row, share, 4)
    length = 1.0 + slope_e**2 + slope_n**2
    along = de * slope_e + dn * slope_n
    distance = np.sqrt(max(de * de + dn * dn - along**2 / length, TINY))
    foot = z + along / length
    row, share = _at(table, (foot - place[0]) / place[1])
    de, dn = de - along * slope_e / length, dn - along * slope_n / length
    left = max(np.sqrt(de * de + dn * dn), TINY)
    return distance, de / left, dn / left, foot, row, share


@compiled
def _off_circle(c: float, s: float, row: int, share: float, harmonics: NDArray[np.complex128]) -> float:
    """What the section is off the circle in the direction (c, s)."""
    off, tc, ts = 0.0, c, s
    for k in range(harmonics.shape[1]):
        tc, ts = tc * c - ts * s, tc * s + ts * c
        low, high = harmonics[row, k], harmonics[row + 1, k]
        off += (low.real + share * (high.real - low.real)) * tc
        off -= (low.imag + share * (high.imag - low.imag)) * ts
    return off


@compiled
def _add(
    cell: NDArray[np.float64], moments: NDArray[np.float64], seen: Seen, sigma: float, cut: float
) -> None:
    """Add a point with residual, cosine, sine, height and foot to a cell (SUMS,) and to the moments."""
    residual, c, s, z, foot = seen
    scaled = (residual / sigma) ** 2
    ratio = min(scaled / cut**2, 1.0)
    robust = (1.0 - ratio) ** 2
    weight = robust / sigma**2
    cell[0] += 1.0
    if ratio < 1.0:
        cell[1] += 1.0
        cell[8] += residual**2
    cell[2] += weight
    cell[3] += weight * residual
    cell[4] += weight * c
    cell[5] += weight * s
    cell[6] += weight * z
    cell[7] += weight * foot
    cell[9] += robust
    moments[0] += robust**2 * scaled
    moments[1] += (1.0 - ratio) * (1.0 - 5.0 * ratio)
    moments[2] += robust


@compiled
def add_points(  # noqa: PLR0913, PLR0917 - a compiled loop
    points_m: NDArray[np.float64],
    station: NDArray[np.uint16],
    origin_m: NDArray[np.float64],
    table: NDArray[np.float64],
    harmonics: NDArray[np.complex128],
    table_place: Place,
    across: bool,
    grid_place: Place,
    sigma_m: NDArray[np.float64],
    cut: float,
    sums: NDArray[np.float64],
    moments: NDArray[np.float64],
) -> None:
    """Add points (n, 3) of stations (n,) to ``sums`` (stations, heights, sectors, SUMS) and ``moments`` (MOMENTS,).

    ``table`` (rows, 5) is the surface by height: axis east and north about ``origin_m``, radius, slopes; ``harmonics``
    (rows, k) what its sections are off the circle. ``table_place`` and ``grid_place`` are lowest height and step of table
    and cells. ``sigma_m`` (stations, sectors) is the noise, ``cut`` where Tukey's biweight ends, in sigmas.
    """
    n_heights, n_sectors = sums.shape[1], sums.shape[2]
    turn_to_sector = n_sectors / (2.0 * np.pi)
    for i in range(len(points_m)):
        z = points_m[i, 2]
        row, share = _at(table, (z - table_place[0]) / table_place[1])
        de = points_m[i, 0] - origin_m[0] - _between(table, row, share, 0)
        dn = points_m[i, 1] - origin_m[1] - _between(table, row, share, 1)
        if across:
            distance, c, s, foot, row, share = _seen_across(de, dn, z, row, share, table, table_place)
        else:
            distance, foot = max(np.sqrt(de * de + dn * dn), TINY), z
            c, s = de / distance, dn / distance
        residual = distance - _between(table, row, share, 2) - _off_circle(c, s, row, share, harmonics)
        sector = int(np.floor(np.arctan2(s, c) * turn_to_sector)) % n_sectors
        height = int(min(max((z - grid_place[0]) / grid_place[1], 0.0), n_heights - 1.0))
        cell = sums[station[i], height, sector]
        _add(cell, moments, (residual, c, s, z, foot), sigma_m[station[i], sector], cut)
