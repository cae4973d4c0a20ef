"""What each station has to say of each slice: its part of the normal equations of a circle."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

COLUMNS: Final = 10
"""Normal matrix (3), score (1), and the derivatives of the score by a rotation about the origin (3) and a shift (3)."""

SIZE_HELD: Final = 1e-9
"""Weight of the known size against the points: nothing where they fix it, everything where they do not."""

LOOSEST: Final = 1e8
"""Condition of normal equations above which the points that are left fix no centre."""

MOST_GROWTH: Final = 9.0
"""A centre whose variance grows more than this without a station is that station's: nothing can be said without it."""


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """Points of a slice that count, and how they lie on its contour.

    Attributes
    ----------
    points_m : (n, 3) array
        Site frame, metres.
    outward : (n, 3) array
        Derivative of the distance from the contour by a shift of the point: its horizontal part is a unit vector.
    residual_m : (n,) array
        Distance from the contour, outward positive, metres.
    station : (n,) array
        Which station saw the point.
    """

    points_m: NDArray[np.float64]
    outward: NDArray[np.float64]
    residual_m: NDArray[np.float64]
    station: NDArray[np.integer]


@dataclass(frozen=True, slots=True)
class Ring:
    """A circle of a leaning, tapering shaft: which points of a slice count, and how they lie on it.

    ``center_m`` (east, north) and ``radius_m`` are those at the height ``z_m``, site frame, metres; ``lean`` and ``taper``
    change them with the height. Points count within ``near_m`` of it.
    """

    center_m: tuple[float, float]
    z_m: float
    radius_m: float
    lean: tuple[float, float]
    taper: float
    near_m: float


def sum_by_station(skin: Skin, n_stations: int) -> NDArray[np.float64]:
    """Sum up the points of a slice by station.

    Returns
    -------
    (n_stations, 3, ``COLUMNS``) array
        For east, north and size of the contour: normal matrix, score, and derivatives of the score by a small rotation
        of the station's points about the origin of the frame and by a shift, each (east, north, up).

    Raises
    ------
    ShapeError
        If the arrays do not fit together.
    """
    n = len(skin.points_m)
    if skin.outward.shape != (n, 3) or skin.residual_m.shape != (n,) or skin.station.shape != (n,):
        raise ShapeError(
            f"sum_by_station needs outward (n, 3), residuals (n,) and stations (n,) of {n} points, "
            f"got {skin.outward.shape}, {skin.residual_m.shape} and {skin.station.shape}"
        )
    from tasks.uncertainty.station_kernel import add_skin  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    sums = np.zeros((n_stations, 3, COLUMNS))
    add_skin(skin.points_m, skin.outward, skin.residual_m, skin.station, sums)
    return sums


def sum_ring_by_station(
    points_m: NDArray[np.float64], station: NDArray[np.integer], ring: Ring, n_stations: int
) -> NDArray[np.float64]:
    """The same (n_stations, 3, ``COLUMNS``) of the points (n, 3) of a slice that lie near a ring.

    Raises
    ------
    ShapeError
        If there is not one station a point.
    """
    from tasks.uncertainty.station_kernel import add_ring  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    if station.shape != (len(points_m),):
        raise ShapeError(
            f"sum_ring_by_station needs a station each of {len(points_m)} points, got {station.shape}"
        )
    sums = np.zeros((n_stations, 3, COLUMNS))
    place = (*ring.center_m, ring.z_m, ring.radius_m, *ring.lean, ring.taper, ring.near_m)
    add_ring(points_m, station, place, sums)
    return sums


def leverage(z_m: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """What the lean of a weighted line changes by if a centre (m,) moves by a metre, 1/m."""
    away = z_m - weights @ z_m / weights.sum()
    return np.asarray(weights * away / (weights @ away**2))


def base_leverage(z_m: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """What a weighted line moves by at z = 0 if a centre (m,) moves by a metre."""
    mean_z = weights @ z_m / weights.sum()
    return np.asarray(weights / weights.sum() - mean_z * leverage(z_m, weights))


def changes_without_each(
    sums: NDArray[np.float64], z_m: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Change (p, 2) of the lean with each of the p stations that have points left out, to first order.

    A slice whose centre the other stations do not fix drops out with the station.

    Parameters
    ----------
    sums : (m, s, 3, ``COLUMNS``) array
        ``sum_by_station`` of every centre.
    z_m, weights : (m,) arrays
        Heights of the centres, metres, and their weights in the axis.

    Returns
    -------
    (p, 2) array or None
        None where without some station fewer than 2 heights are left.
    """
    present = np.flatnonzero(sums[:, :, 2, 2].any(axis=0))
    total = sums.sum(axis=1)
    changes = np.zeros((len(present), 2))
    for row, station in enumerate(present):
        left = total - sums[:, station]
        fixed = _still_fixed(total, left) & (weights > 0.0)
        if np.count_nonzero(fixed) < 2 or np.ptp(z_m[fixed]) == 0.0:
            return None
        moved = _centres(left[fixed]) - _centres(total[fixed])
        changes[row] = leverage(z_m[fixed], weights[fixed]) @ moved
    return changes


def pose_jacobian(
    sums: NDArray[np.float64],
    z_m: NDArray[np.float64],
    weights: NDArray[np.float64],
    positions_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Change (2, 6 s) of the lean with the pose parameters of the stations at positions (s, 3), metres."""
    return moved_by_poses(sums, leverage(z_m, weights), positions_m)


def moved_by_poses(
    sums: NDArray[np.float64], levers: NDArray[np.float64], positions_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Change (2, 6 s) with the pose parameters of what follows the centres by levers (m,)."""
    total = sums.sum(axis=1)
    normal = total[:, :, :3].copy()
    # where the points leave the size open (two faces that meet), the size is what was known before and stays
    normal[:, 2, 2] *= 1.0 + SIZE_HELD
    pull = (np.linalg.pinv(normal, hermitian=True)[:, None] @ sums[:, :, :, 4:])[:, :, :2]
    by_pose = np.einsum("m,msab->sab", levers, pull)
    shift = by_pose[:, :, 3:]
    # a rotation about the station's own origin turns the lever arm p - position
    by_pose[:, :, :3] -= np.cross(positions_m[:, None, :], shift)
    return np.asarray(by_pose.transpose(1, 0, 2).reshape(2, -1))


def _still_fixed(total: NDArray[np.float64], left: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which centres (m,) are still fixed by the sums (m, 3, ``COLUMNS``) that are left of the total."""
    fixed = (np.linalg.cond(total[:, :, :3]) < LOOSEST) & (np.linalg.cond(left[:, :, :3]) < LOOSEST)
    before, after = (
        np.trace(np.linalg.inv(part[fixed][:, :, :3])[:, :2, :2], axis1=1, axis2=2) for part in (total, left)
    )
    fixed[fixed] = after <= MOST_GROWTH * before
    return np.asarray(fixed)


def _centres(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """Step (m, 2) of the centres that these sums (m, 3, ``COLUMNS``) ask for, metres."""
    return np.asarray(np.linalg.solve(sums[:, :, :3], sums[:, :, 3:4])[:, :2, 0])
