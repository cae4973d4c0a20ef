"""Compare two placed scans: point-to-plane residuals with their derivatives by both poses."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import mad_sigma
from tasks.registration.planar import PlanarCloud
from tasks.registration.station import StationPose

QUERIES: Final = 3000
"""Points of one scan that look for a partner in another; evenly taken, no chance."""

NORMAL_COSINE: Final = float(np.cos(np.radians(25.0)))
MIN_SIGMA_M: Final = 0.006
MIN_MATCHES: Final = 30
CORRELATION: Final = 24.0
"""Neighbouring residuals are not independent: their information is divided by this. Chosen so that simulated
poses scatter about their truth as their covariance says (8, 3 and 2 stations)."""


@dataclass(frozen=True, slots=True)
class Matches:
    """Matched points (m, 3), normals (m, 3), tilts of the normals (m, 2, 3), residuals (m,): all in the site frame."""

    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    tilts: NDArray[np.float64]
    residuals_m: NDArray[np.float64]
    n_queries: int

    @property
    def sigma_m(self) -> float | None:
        """Robust scale of the residuals, not below 6 mm; None with too few matches."""
        return None if len(self.residuals_m) < MIN_MATCHES else max(mad_sigma(self.residuals_m), MIN_SIGMA_M)


@dataclass(frozen=True, slots=True)
class PairEquations:
    """Normal equations (12, 12) and (12,) of one ordered pair, source first."""

    matrix: NDArray[np.float64]
    vector: NDArray[np.float64]


NO_EQUATIONS: Final = PairEquations(np.zeros((12, 12)), np.zeros(12))


def match_pair(
    source: PlanarCloud,
    source_pose: StationPose,
    target: PlanarCloud,
    target_pose: StationPose,
    gate_m: float,
) -> Matches:
    """Find the planes of the target that points of the source lie in.

    A residual is n . (p - q) in the site frame, p moving with the source, q and n with the target.
    """
    step = max(1, len(source.points_m) // QUERIES)
    points = source_pose.to_site(source.points_m[::step])
    normals = source.normals[::step] @ source_pose.rotation.T
    # searched in the target's own frame, so that its tree is built once; the gate holds along the normal, because
    # the nearest target point lies up to its spacing away within the same plane
    local = (points - target_pose.position_m) @ target_pose.rotation
    distance, index = target.tree.query(local, distance_upper_bound=max(gate_m, target.reach_m))
    near = np.flatnonzero(np.isfinite(distance))
    partner = index[near]
    planes = target.normals[partner] @ target_pose.rotation.T
    alike = np.abs(np.einsum("ij,ij->i", planes, normals[near])) > NORMAL_COSINE
    near, partner, planes = near[alike], partner[alike], planes[alike]
    apart = points[near] - target_pose.to_site(target.points_m[partner])
    residuals = np.einsum("ij,ij->i", planes, apart)
    close = np.abs(residuals) <= gate_m
    tilts = target.tilts[partner[close]] @ target_pose.rotation.T
    return Matches(points[near[close]], planes[close], tilts, residuals[close], len(points))


def pair_equations(matches: Matches, source_pose: StationPose, target_pose: StationPose) -> PairEquations:
    """Linearise the residuals; Geman-McClure weights with the robust scale of the pair."""
    weight = match_weights(matches)
    if weight is None:
        return NO_EQUATIONS
    jacobian = derivatives(matches.points_m, matches.normals, source_pose, target_pose)
    weighted = jacobian * weight[:, None]
    return PairEquations(weighted.T @ jacobian, -weighted.T @ matches.residuals_m)


def feigned_information(
    matches: Matches, source_pose: StationPose, target_pose: StationPose
) -> NDArray[np.float64]:
    """Information (12, 12) that is not there: what the noise of the normals adds to the normal matrix on average.

    On a round shaft it looks as if the scans knew their yaw about its axis.
    """
    weight = match_weights(matches)
    if weight is None:
        return np.zeros((12, 12))
    total = np.zeros((12, 12))
    for tilt in (matches.tilts[:, 0], matches.tilts[:, 1]):
        wrong = derivatives(matches.points_m, tilt, source_pose, target_pose)
        total += (wrong * weight[:, None]).T @ wrong
    return total


def match_weights(matches: Matches) -> NDArray[np.float64] | None:
    """Weights (m,) in 1 / m2; None with too few matches."""
    sigma = matches.sigma_m
    if sigma is None:
        return None
    robust = 1.0 / (1.0 + (matches.residuals_m / (3.0 * sigma)) ** 2) ** 2
    return np.asarray(robust / (sigma**2 * CORRELATION))


def derivatives(
    points_m: NDArray[np.float64],
    normals: NDArray[np.float64],
    source_pose: StationPose,
    target_pose: StationPose,
) -> NDArray[np.float64]:
    """Derivatives (m, 12) of n . (p - q) by the poses of source and target, for points (m, 3), normals (m, 3)."""
    by_source = np.cross(points_m - source_pose.position_m, normals)
    by_target = -np.cross(points_m - target_pose.position_m, normals)
    return np.hstack([by_source, normals, by_target, -normals])
