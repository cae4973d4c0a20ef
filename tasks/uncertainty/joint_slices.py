"""Axis and radius of slices as a few numbers with a joint covariance, for comparing epochs."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.axis_parameters import AXIS_NAMES, RADIUS_TERMS, JointParts, radius_names
from tasks.uncertainty.station_sums import base_leverage, leverage

LEAST_FOR_BEND: Final = 6
LEAST_FOR_S_BEND: Final = 12
LEAST_FOR_PROFILE: Final = 12
"""With fewer centres there is no bending, none in the shape of an S, and no radius but a cone."""

LOOSEST: Final = 1e8
"""Condition of a slice's normal equations above which its points fix no size."""


@dataclass(frozen=True, slots=True, eq=False)
class SlicedShaft:
    """Slices that gave a centre, bottom up.

    ``centres_m`` (m, 3), their point covariances (m, 2, 2), ``radius_m`` (m,), weights in the axis (m,), ``sums``
    (m, s, 3, 10) of the stations, and the ends of the part that was cut, metres.
    """

    centres_m: NDArray[np.float64]
    covariances_m2: NDArray[np.float64]
    radius_m: NDArray[np.float64]
    levers: NDArray[np.float64]
    sums: NDArray[np.float64]
    ends_m: tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class PlacedStations:
    """Stations at ``positions_m`` (s, 3) with the covariance (6 s, 6 s) of their poses, and the part of the frame."""

    positions_m: NDArray[np.float64]
    pose_covariance: NDArray[np.float64]
    frame_covariance: NDArray[np.float64] | None


@dataclass(frozen=True, slots=True, eq=False)
class JointSlices:
    """Names, functions (p, m, 3) of east, north and size of the slices, and the values (p,) that they give."""

    names: tuple[str, ...]
    rows: NDArray[np.float64]
    values: NDArray[np.float64]


def joint_slices(shaft: SlicedShaft) -> JointSlices:
    """Take the parameters of axis and radius out of slices."""
    z_m, m = shaft.centres_m[:, 2], len(shaft.centres_m)
    functions = [base_leverage(z_m, shaft.levers), leverage(z_m, shaft.levers)]
    if m >= LEAST_FOR_BEND:
        functions.append(_legendre_rows(shaft, 3)[2])
    if m >= LEAST_FOR_S_BEND:
        functions.append(_legendre_rows(shaft, 4)[3])
    n_radius = RADIUS_TERMS if m >= LEAST_FOR_PROFILE else 2
    rows = np.zeros((2 * len(functions) + n_radius, m, 3))
    for number, function in enumerate(functions):
        rows[2 * number, :, 0] = rows[2 * number + 1, :, 1] = function
    rows[2 * len(functions) :, :, 2] = _legendre_rows(shaft, n_radius)
    names = AXIS_NAMES[: 2 * len(functions)] + radius_names(n_radius)
    observed = np.column_stack([shaft.centres_m[:, :2], shaft.radius_m])
    return JointSlices(names, rows, np.einsum("pmk,mk->p", rows, observed))


def joint_parts(
    shaft: SlicedShaft,
    rows: NDArray[np.float64],
    stations: PlacedStations,
    form_share: float,
) -> JointParts:
    """Joint covariance of functions (p, m, 3) of the slices: of points and poses, and of the form of the wall.

    ``form_share`` is what the form adds to the variance of the points, as a share of it.
    """
    noise = np.einsum("pmk,mkl,qml->pq", rows, _of_each(shaft), rows)
    jacobian = _by_poses(shaft.sums, rows, stations.positions_m)
    frame = np.zeros_like(noise)
    if stations.frame_covariance is not None:
        frame = jacobian @ stations.frame_covariance @ jacobian.T
    own = noise + jacobian @ stations.pose_covariance @ jacobian.T
    return JointParts(own, form_share * noise, frame)


def _legendre_rows(shaft: SlicedShaft, count: int) -> NDArray[np.float64]:
    """Functions (count, m) that take Legendre coefficients over the cut part out of values at the slices.

    All slices count alike: what the profile is beyond these polynomials is then the same in every epoch, and cancels.
    """
    low, high = shaft.ends_m
    share = (2.0 * shaft.centres_m[:, 2] - low - high) / (high - low)
    return np.asarray(np.linalg.pinv(np.polynomial.legendre.legvander(share, count - 1)))


def _of_each(shaft: SlicedShaft) -> NDArray[np.float64]:
    """Covariance (m, 3, 3) of east, north and size of every slice from its points.

    That of the centre is known; the points say how the size hangs on it.
    """
    normal = shaft.sums.sum(axis=1)[:, :, :3]
    made = np.zeros((len(normal), 3, 3))
    made[:, :2, :2] = shaft.covariances_m2
    made[:, 2, 2] = np.trace(shaft.covariances_m2, axis1=1, axis2=2) / 4.0
    tell = np.linalg.cond(normal) < LOOSEST
    inverse = np.linalg.inv(normal[tell])
    trace = np.trace(inverse[:, :2, :2], axis1=1, axis2=2)
    known = np.trace(shaft.covariances_m2[tell], axis1=1, axis2=2)
    made[tell] = inverse * (known / trace)[:, None, None]
    return made


def _by_poses(
    sums: NDArray[np.float64], rows: NDArray[np.float64], positions_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Change (p, 6 s) of functions of the slices with the pose parameters of the stations."""
    normal = sums.sum(axis=1)[:, :, :3]
    pull = np.linalg.pinv(normal, hermitian=True)[:, None] @ sums[:, :, :, 4:]
    by_pose = np.einsum("pmk,mskb->psb", rows, pull)
    shift = by_pose[:, :, 3:]
    # a rotation about the station's own origin turns the lever arm p - position
    by_pose[:, :, :3] -= np.cross(positions_m[None], shift)
    return np.asarray(by_pose.reshape(len(rows), -1))
