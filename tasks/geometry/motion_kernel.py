"""Rigid motion of points, compiled: a product of matrices spends its time on being called for three columns."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled


@compiled
def move_points(
    points_m: NDArray[np.float64],
    rotation: NDArray[np.float64],
    shift_m: NDArray[np.float64],
    moved_m: NDArray[np.float64],
) -> None:
    """Write rotation (3, 3) @ point + shift (3,) of points (n, 3); ``moved_m`` may be the points themselves."""
    for i in range(len(points_m)):
        x, y, z = points_m[i, 0], points_m[i, 1], points_m[i, 2]
        for k in range(3):
            moved_m[i, k] = rotation[k, 0] * x + rotation[k, 1] * y + rotation[k, 2] * z + shift_m[k]
