"""The loop over points that finds how far each may lie off the surface along its line of sight, compiled."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled
from tasks.geometry.knot_kernel import knot_below

TINY: Final = float(np.finfo(np.float64).tiny)

Scanner = tuple[float, float, float, float, float]
"""Range sigma at the stated distance, that distance, the least part of it, angle sigma and roughness."""


@compiled
def add_sights(  # noqa: PLR0913, PLR0917 - a compiled loop
    points_m: NDArray[np.float64],
    station: NDArray[np.integer],
    positions_m: NDArray[np.float64],
    knots_z_m: NDArray[np.float64],
    axis: NDArray[np.float64],
    slopes: NDArray[np.float64],
    scanner: Scanner,
    sigma_m: NDArray[np.float64],
) -> None:
    """Sigmas (n,) of points (n, 3); ``axis`` (3, k) and ``slopes`` (3, k - 1) are east, north and radius at the knots."""
    range_sigma, stated_at, least_part, angle_sigma, roughness = scanner
    knot = 0
    for i in range(len(points_m)):
        up = points_m[i, 2]
        knot = knot_below(knots_z_m, up, knot)
        lean_east, lean_north, taper = slopes[0, knot], slopes[1, knot], slopes[2, knot]
        above = up - knots_z_m[knot]
        out_east = points_m[i, 0] - axis[0, knot] - above * lean_east
        out_north = points_m[i, 1] - axis[1, knot] - above * lean_north
        # a point on the axis itself has no normal: 0 / tiny makes it level, and its sigma that of a grazing sight
        out = max(np.sqrt(out_east * out_east + out_north * out_north), TINY)
        # gradient of |p - c(z)| - R(z): the outward normal of a leaning, tapering shaft, not yet of length one
        rising = -(out_east * lean_east + out_north * lean_north) / out - taper
        sight_east = points_m[i, 0] - positions_m[station[i], 0]
        sight_north = points_m[i, 1] - positions_m[station[i], 1]
        sight_up = up - positions_m[station[i], 2]
        distance_2 = max(sight_east**2 + sight_north**2 + sight_up**2, TINY)
        along = (out_east * sight_east + out_north * sight_north) / out + rising * sight_up
        cos_2 = min(along**2 / ((1.0 + rising**2) * distance_2), 1.0)
        range_2 = range_sigma**2 * max(distance_2 / stated_at**2, least_part**2)
        across_2 = angle_sigma**2 * distance_2
        sigma_m[i] = np.sqrt(range_2 * cos_2 + across_2 * (1.0 - cos_2) + roughness**2)
