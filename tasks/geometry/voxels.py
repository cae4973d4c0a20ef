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
    if len(points_m) == 0:
        return np.empty(0, dtype=np.int64)
    cells = np.floor((points_m - points_m.min(axis=0)) / voxel_m).astype(np.int64)
    if int(cells.max()) >= 2**21:
        raise OverflowError(
            f"a cloud of {cells.max() + 1} voxels of {voxel_m} m along one axis does not fit the grid"
        )
    key = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    _, first = np.unique(key, return_index=True)
    return np.sort(first).astype(np.int64)
