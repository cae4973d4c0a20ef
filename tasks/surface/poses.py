"""What the pose errors of the stations do to the points of a surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.surface.cells import Cells
from tasks.surface.profile import Profile

HALF_STEP_M = 0.25
"""Half of the height over which the taper of the skin is taken, metres."""

PARAMETERS = 6


@dataclass(frozen=True, slots=True, eq=False)
class StationPoses:
    """Stations at ``positions_m`` (s, 3), site frame, metres, and the covariance (6 s, 6 s) of their poses.

    ``frame_covariance`` is the part of it that the frame of the reference epoch brings along; None where nothing does.
    """

    positions_m: NDArray[np.float64]
    covariance: NDArray[np.float64]
    frame_covariance: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        n = PARAMETERS * len(self.positions_m)
        if self.positions_m.shape[1:] != (3,) or self.covariance.shape != (n, n):
            raise ShapeError(
                f"StationPoses needs positions (s, 3) and a covariance (6 s, 6 s), got {self.positions_m.shape} "
                f"and {self.covariance.shape}"
            )

    def factor(self) -> NDArray[np.float64]:
        """A matrix (6 s, r) whose product with its transpose is the covariance, singular or not."""
        values, vectors = np.linalg.eigh((self.covariance + self.covariance.T) / 2.0)
        kept = values > 1e-12 * float(values[-1])
        return np.asarray(vectors[:, kept] * np.sqrt(values[kept]))


def by_own_pose(cells: Cells, profile: Profile, poses: StationPoses) -> NDArray[np.float64]:
    """Change (c, 6) of the residual of each cell with the pose of its own station: rotations, then shifts."""
    radius = profile.radius_at(cells.z_m)
    axis = profile.axis_at(cells.z_m) + profile.origin_m
    outward = cells.direction / np.abs(cells.direction)
    points = np.column_stack(
        [axis[:, 0] + radius * outward.real, axis[:, 1] + radius * outward.imag, cells.z_m]
    )
    above, below = (profile.radius_at(cells.z_m + step) for step in (HALF_STEP_M, -HALF_STEP_M))
    slope = profile.slope_at(cells.z_m)
    lift = -(above - below) / (2.0 * HALF_STEP_M) - slope[:, 0] * outward.real - slope[:, 1] * outward.imag
    skin = np.column_stack([outward.real, outward.imag, lift])
    arm = points - poses.positions_m[cells.station]
    return np.concatenate([np.cross(arm, skin), skin], axis=1)


def by_pose_factors(
    cells: Cells, own: NDArray[np.float64], factor: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Change (c, r) of the residuals with independent unit errors that make up all poses (``factor`` (6 s, r))."""
    blocks = factor.reshape(len(factor) // PARAMETERS, PARAMETERS, factor.shape[1])
    terms = np.empty((len(own), factor.shape[1]))
    for station, block in enumerate(blocks):
        mine = cells.station == station
        terms[mine] = own[mine] @ block
    return terms


def jacobian_of_poses(
    cells: Cells, own: NDArray[np.float64], pull: NDArray[np.float64], n_stations: int
) -> NDArray[np.float64]:
    """Change (k, 6 s) with the poses of quantities that follow the residuals of the cells by ``pull`` (k, c)."""
    jacobian = np.zeros((len(pull), n_stations, PARAMETERS))
    for station in range(n_stations):
        mine = cells.station == station
        jacobian[:, station] = pull[:, mine] @ own[mine]
    return jacobian.reshape(len(pull), -1)
