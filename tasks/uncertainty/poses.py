"""Covariance of the lean vector from the covariance of the stations' poses."""

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.conventions import PARAMETERS_PER_STATION


def propagate_poses(
    pose_covariance: NDArray[np.float64],
    shares: NDArray[np.float64],
    lean: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Covariance of the lean vector that the pose errors of the stations cause.

    A small rotation w of a station about its own origin p_s moves a point p by w x (p - p_s): per unit
    of height the axis of a plumb shaft moves by (+w_north, -w_east) times the station's share in the axis.
    Shifts, and the part of w x (p - p_s) that is constant over height, cancel as long as the shares do
    not depend on height, which is assumed here; so is that a station pulls the centres equally in all
    directions (``propagate_directional_poses`` does without the latter).
    Of a leaning shaft the heading error turns the lean: that needs ``lean``.

    Parameters
    ----------
    pose_covariance : (6 n, 6 n) array
        Covariance of the poses, in the order of ``tasks.conventions``.
    shares : (n,) array
        Weight of each station in the axis, not negative, sum 1.
    lean : (2,) array, optional
        Lean vector (east, north) of the axis; a plumb axis without it.

    Returns
    -------
    (2, 2) array
        Covariance of (lean_east, lean_north), dimensionless.

    Raises
    ------
    ShapeError
        If shapes disagree, values are not finite, or the shares are negative or do not sum to 1.
    """
    weights = np.asarray(shares, dtype=np.float64)
    if weights.ndim != 1 or len(weights) == 0 or not np.isfinite(weights).all() or (weights < 0.0).any():
        raise ShapeError(f"propagate_poses needs finite shares (n,) that are not negative; got {shares!r}")
    if abs(weights.sum() - 1.0) > 1e-6:
        raise ShapeError(f"propagate_poses needs shares that sum to 1; got a sum of {weights.sum()}")
    return propagate_directional_poses(pose_covariance, weights[:, None, None] * np.eye(2), lean)


def propagate_directional_poses(
    pose_covariance: NDArray[np.float64],
    share_matrices: NDArray[np.float64],
    lean: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Do the same with a matrix as share: what a station that sees one side only does to the centres.

    A share matrix W_s turns a horizontal shift of the station's points into the shift of the fitted
    centre: (sum of I_k)^-1 I_s with I_s the information (2, 2) of the station about a centre.

    Parameters
    ----------
    pose_covariance : (6 n, 6 n) array
        Covariance of the poses, in the order of ``tasks.conventions``.
    share_matrices : (n, 2, 2) array
        Share of each station, the same at every height; they sum to the unit matrix.
    lean : (2,) array, optional
        Lean vector (east, north) of the axis; a plumb axis without it.

    Returns
    -------
    (2, 2) array
        Covariance of (lean_east, lean_north), dimensionless.

    Raises
    ------
    ShapeError
        If shapes disagree, values are not finite, or the shares do not sum to the unit matrix.
    """
    shares = np.asarray(share_matrices, dtype=np.float64)
    if (
        shares.ndim != 3
        or shares.shape[1:] != (2, 2)
        or not np.allclose(shares.sum(axis=0), np.eye(2), atol=1e-6)
    ):
        raise ShapeError(
            f"propagate_directional_poses needs share matrices (n, 2, 2) that sum to the unit matrix; "
            f"got {shares.shape}"
        )
    C = _checked_poses(pose_covariance, len(shares))
    per_station = np.zeros((2, PARAMETERS_PER_STATION))
    per_station[:, :3] = _lean_by_rotation(lean)
    J = np.concatenate([share @ per_station for share in shares], axis=1)
    return np.asarray(J @ C @ J.T)


def combine(point_cov: NDArray[np.float64], pose_cov: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (2, 2) of the lean vector from points and poses together, taken as independent.

    Raises
    ------
    ShapeError
        If either is not a finite (2, 2) array.
    """
    parts = [np.asarray(part, dtype=np.float64) for part in (point_cov, pose_cov)]
    if any(part.shape != (2, 2) or not np.isfinite(part).all() for part in parts):
        raise ShapeError(f"combine needs two finite covariances (2, 2); got {point_cov!r} and {pose_cov!r}")
    return np.asarray(parts[0] + parts[1])


def _lean_by_rotation(lean: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """Derivative (2, 3) of the lean vector by a rotation of the direction (lean, 1)."""
    tau = np.zeros(2) if lean is None else np.asarray(lean, dtype=np.float64)
    if tau.shape != (2,) or not np.isfinite(tau).all():
        raise ShapeError(f"propagate_poses needs a finite lean vector (2,); got {lean!r}")
    e, n = tau
    w_cross_d = np.array([[0.0, 1.0, -n], [-1.0, 0.0, e], [n, -e, 0.0]])
    # d(d_h / d_u) at d_u = 1
    return np.asarray(w_cross_d[:2] - np.outer(tau, w_cross_d[2]))


def _checked_poses(pose_covariance: NDArray[np.float64], n_stations: int) -> NDArray[np.float64]:
    C = np.asarray(pose_covariance, dtype=np.float64)
    size = PARAMETERS_PER_STATION * n_stations
    if C.shape != (size, size) or not np.isfinite(C).all():
        raise ShapeError(
            f"propagate_poses needs a finite pose covariance ({size}, {size}) for {n_stations} stations; "
            f"got {C.shape}"
        )
    return C
