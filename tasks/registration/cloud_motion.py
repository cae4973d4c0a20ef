"""A rigid motion between the frames of two clouds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.rotations import nearest_rotation, rotation_from_vector


@dataclass(frozen=True, slots=True)
class RigidMotion:
    """T_fixed_moving: ``points_fixed = rotation @ points_moving + translation``.

    ``rotation`` (3, 3) is proper, ``translation`` (3,) in the unit of the clouds.
    """

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    def to_fixed(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) of the moving frame in the fixed frame."""
        return np.asarray(points @ self.rotation.T + self.translation)

    def inverse(self) -> "RigidMotion":
        """T_moving_fixed."""
        return RigidMotion(self.rotation.T.copy(), -self.rotation.T @ self.translation)

    def turned(self, rotation_rad: NDArray[np.float64], shift: NDArray[np.float64]) -> "RigidMotion":
        """Motion that continues with a rotation vector (3,) about the moving frame's origin, then a shift (3,)."""
        rotation = nearest_rotation(rotation_from_vector(rotation_rad) @ self.rotation)
        return RigidMotion(rotation, self.translation + shift)


def typical_distance(one: RigidMotion, other: RigidMotion, points_moving: NDArray[np.float64]) -> float:
    """Root mean square of how far two motions put the same points (n, 3) apart; unit of the points."""
    apart = one.to_fixed(points_moving) - other.to_fixed(points_moving)
    return float(np.sqrt(np.mean(np.sum(apart * apart, axis=1))))
