"""What errors of the stations' poses do to a map of the surface."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION
from tasks.map_cells import MapGrid
from tasks.registration import Registration


@dataclass(frozen=True, slots=True, eq=False)
class SeenPieces:
    """The pieces of a map that have points.

    Attributes
    ----------
    grid : MapGrid
        The map.
    cell : (k,) array
        Which pieces.
    points_m : (k, 3) array
        Their middles on the skin, site frame, metres.
    outward : (k, 3) array
        Derivative of the distance from the skin by a shift of the points there; its horizontal part is a unit vector.
    shares : (k, s) array
        Share of every station in the points of each.
    """

    grid: MapGrid
    cell: NDArray[np.intp]
    points_m: NDArray[np.float64]
    outward: NDArray[np.float64]
    shares: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PlacingSpread:
    """Standard deviations (k,) of the pieces by the poses of the stations, metres.

    ``own`` of distances from the shaft's own axis and radii, which follow what all pieces share; ``fixed`` of distances
    from a shaft that stands where it is stated to; ``from_foot`` of distances from one that stands where the own axis has
    its foot.
    """

    own: NDArray[np.float64]
    fixed: NDArray[np.float64]
    from_foot: NDArray[np.float64]


def placing_spread(pieces: SeenPieces, registration: Registration, foot_z_m: float) -> PlacingSpread:
    """Propagate the covariance of the poses to the pieces; axis and radii follow by least squares, all pieces alike."""
    shift = _by_poses(pieces, registration)
    terms = _terms(pieces, foot_z_m)
    follows = np.linalg.lstsq(terms, shift, rcond=None)[0]
    own = shift - terms @ follows
    from_foot = shift - terms[:, :2] @ follows[:2]
    covariance = registration.covariance
    return PlacingSpread(_sd(own, covariance), _sd(shift, covariance), _sd(from_foot, covariance))


def _by_poses(pieces: SeenPieces, registration: Registration) -> NDArray[np.float64]:
    """Shift (k, 6 s) of every piece outward by the pose parameters of the stations."""
    positions_m = np.array([pose.position_m for pose in registration.poses])
    arm = pieces.points_m[:, None, :] - positions_m
    turned = np.cross(arm, pieces.outward[:, None, :])
    moved = np.broadcast_to(pieces.outward[:, None, :], arm.shape)
    both = np.concatenate([turned, moved], axis=2) * pieces.shares[:, :, None]
    return np.asarray(both.reshape(len(arm), PARAMETERS_PER_STATION * len(positions_m)))


def _terms(pieces: SeenPieces, foot_z_m: float) -> NDArray[np.float64]:
    """Derivatives (k, 4 + b) of the pieces by the axis at the foot, the lean and the radii of the bands."""
    flat = pieces.outward[:, :2]
    rise = pieces.points_m[:, 2] - foot_z_m
    ring = pieces.grid.band[pieces.cell][:, None] == np.arange(pieces.grid.n_bands)
    return np.concatenate([flat, rise[:, None] * flat, ring.astype(np.float64)], axis=1)


def _sd(jacobian: NDArray[np.float64], covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    variance = np.einsum("ki,ij,kj->k", jacobian, covariance, jacobian, optimize=True)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))
