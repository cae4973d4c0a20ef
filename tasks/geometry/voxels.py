"""Thin a cloud on a regular grid."""

import numpy as np
from numpy.typing import NDArray


def first_in_voxel(points_m: NDArray[np.float64], voxel_m: float) -> NDArray[np.int64]:
    """Indices (k,), ascending, of the first point in each occupied cube of edge ``voxel_m``.

    The grid starts at the cloud's own minimum, so that far coordinates cannot overflow the key.

    Raises
    ------
    OverflowError
        If the cloud spans more than 2**21 cubes along an axis.
    """
    from tasks.geometry.voxel_kernel import AXIS_BITS, bounds, first_of_cubes  # noqa: PLC0415 (slow to import)

    if len(points_m) == 0:
        return np.empty(0, dtype=np.int64)
    points_m = np.ascontiguousarray(points_m, dtype=np.float64)
    low_m, high_m = bounds(points_m)
    n_cubes = float(np.max(np.floor((high_m - low_m) / voxel_m))) + 1.0
    if not n_cubes <= 2**AXIS_BITS:
        raise OverflowError(
            f"a cloud of {n_cubes:.0f} voxels of {voxel_m} m along one axis does not fit the grid"
        )
    return np.flatnonzero(first_of_cubes(points_m, low_m, voxel_m))
