"""The loops over the points of a slice that sum them up by station, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled

TINY: Final = float(np.finfo(np.float64).tiny)

Vector = tuple[float, float, float]

Ring = tuple[float, float, float, float, float, float, float, float]
"""Centre east and north, its height, radius, lean east and north, taper, and how far off it points count."""


@compiled
def _add(sums: NDArray[np.float64], point: Vector, outward: Vector, residual: float) -> None:
    """Add a point to the sums (3, 10) of its station."""
    px, py, pz = point
    ox, oy, oz = outward
    turned_x, turned_y, turned_z = py * oz - pz * oy, pz * ox - px * oz, px * oy - py * ox
    for row in range(3):
        term = ox if row == 0 else oy if row == 1 else 1.0
        sums[row, 0] += term * ox
        sums[row, 1] += term * oy
        sums[row, 2] += term
        sums[row, 3] += term * residual
        sums[row, 4] += term * turned_x
        sums[row, 5] += term * turned_y
        sums[row, 6] += term * turned_z
        sums[row, 7] += term * ox
        sums[row, 8] += term * oy
        sums[row, 9] += term * oz


@compiled
def add_skin(
    points_m: NDArray[np.float64],
    outward: NDArray[np.float64],
    residual_m: NDArray[np.float64],
    station: NDArray[np.integer],
    sums: NDArray[np.float64],
) -> None:
    """Add points (n, 3) that lie on a contour with outward directions (n, 3) to sums (stations, 3, 10)."""
    for i in range(len(points_m)):
        if 0 <= station[i] < len(sums):
            point = (points_m[i, 0], points_m[i, 1], points_m[i, 2])
            _add(sums[station[i]], point, (outward[i, 0], outward[i, 1], outward[i, 2]), residual_m[i])


@compiled
def add_ring(
    points_m: NDArray[np.float64], station: NDArray[np.integer], ring: Ring, sums: NDArray[np.float64]
) -> None:
    """Add points (n, 3) of a slice of a round shaft to sums (stations, 3, 10), those near its circle."""
    east, north, z_m, radius, lean_east, lean_north, taper, near = ring
    for i in range(len(points_m)):
        rise = points_m[i, 2] - z_m
        x = points_m[i, 0] - east - rise * lean_east
        y = points_m[i, 1] - north - rise * lean_north
        distance = max(np.sqrt(x * x + y * y), TINY)
        residual = distance - radius - taper * rise
        if abs(residual) <= near and 0 <= station[i] < len(sums):
            x, y = x / distance, y / distance
            point = (points_m[i, 0], points_m[i, 1], points_m[i, 2])
            outward = (x, y, -taper - (x * lean_east + y * lean_north))
            _add(sums[station[i]], point, outward, residual)
