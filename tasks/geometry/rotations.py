"""Rotations in three dimensions."""

import numpy as np
from numpy.typing import NDArray


def rotation_from_vector(rotation_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrix (3, 3) of a rotation vector (3,): axis times angle, by Rodrigues' formula."""
    angle = float(np.linalg.norm(rotation_rad))
    if angle == 0.0:
        return np.eye(3)
    k = cross_matrix(rotation_rad / angle)
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * (k @ k))


def cross_matrix(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix (3, 3) that takes the cross product with ``vector`` (3,) from the left."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def nearest_rotation(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation (3, 3) nearest to ``matrix`` in the least-squares sense (removes rounding drift)."""
    u, _, vt = np.linalg.svd(matrix)
    return np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt)
