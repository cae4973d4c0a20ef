"""Compare two placed scans: point-to-plane residuals with their derivatives by both poses."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import mad_sigma
from tasks.registration.planar import PlanarCloud
from tasks.registration.station import StationPose

QUERIES: Final = 5000
"""Points of one scan that look for a partner in another; evenly taken, no chance."""

NORMAL_COSINE: Final = float(np.cos(np.radians(25.0)))
MIN_SIGMA_M: Final = 0.006
MIN_MATCHES: Final = 30
REACH_M: Final = 0.5
"""A plane holds at least this far from the point that stands for it: clouds are thinned to 0.2 m."""

CORRELATION: Final = 45.0
"""Neighbouring residuals are not independent: their information is divided by this. Chosen so that simulated
poses scatter about their truth as their covariance says (8, 3 and 2 stations)."""


@dataclass(frozen=True, slots=True)
class PairEquations:
    """Normal equations (12, 12) and (12,) of one ordered pair, source first; and its figures."""

    matrix: NDArray[np.float64]
    vector: NDArray[np.float64]
    n_queries: int
    n_matches: int
    sigma_m: float | None


def pair_equations(
    source: PlanarCloud,
    source_pose: StationPose,
    target: PlanarCloud,
    target_pose: StationPose,
    gate_m: float,
) -> PairEquations:
    """Linearise the distances of source points from the planes of their nearest target points.

    A residual is n . (p - q) in the site frame, p moving with the source, q and n with the target.
    Geman-McClure weights with the MAD scale of the pair.
    """
    step = max(1, len(source.points_m) // QUERIES)
    points, normals = source.points_m[::step], source.normals[::step]
    matched = _matches(
        source_pose.to_site(points), normals @ source_pose.rotation.T, target, target_pose, gate_m
    )
    n_matches = len(matched.residuals_m)
    if n_matches < MIN_MATCHES:
        return PairEquations(np.zeros((12, 12)), np.zeros(12), len(points), n_matches, None)
    sigma = max(mad_sigma(matched.residuals_m), MIN_SIGMA_M)
    weight = 1.0 / (1.0 + (matched.residuals_m / (3.0 * sigma)) ** 2) ** 2 / (sigma**2 * CORRELATION)
    jacobian = _jacobian(matched, source_pose, target_pose)
    weighted = jacobian * weight[:, None]
    return PairEquations(
        weighted.T @ jacobian, -weighted.T @ matched.residuals_m, len(points), n_matches, sigma
    )


@dataclass(frozen=True, slots=True)
class _Matches:
    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    residuals_m: NDArray[np.float64]


def _matches(
    points_site_m: NDArray[np.float64],
    normals_site: NDArray[np.float64],
    target: PlanarCloud,
    target_pose: StationPose,
    gate_m: float,
) -> _Matches:
    # searched in the target's own frame, so that its tree is built once; the gate holds along the normal, because
    # the nearest target point lies up to its spacing away within the same plane
    local = (points_site_m - target_pose.position_m) @ target_pose.rotation
    distance, index = target.tree.query(local, distance_upper_bound=max(gate_m, REACH_M))
    near = np.isfinite(distance)
    partner, points = index[near], points_site_m[near]
    normals = target.normals[partner] @ target_pose.rotation.T
    alike = np.abs(np.einsum("ij,ij->i", normals, normals_site[near])) > NORMAL_COSINE
    normals, points = normals[alike], points[alike]
    apart = points - target_pose.to_site(target.points_m[partner[alike]])
    residuals = np.einsum("ij,ij->i", normals, apart)
    close = np.abs(residuals) <= gate_m
    return _Matches(points[close], normals[close], residuals[close])


def _jacobian(matched: _Matches, source_pose: StationPose, target_pose: StationPose) -> NDArray[np.float64]:
    n = matched.normals
    by_source = np.cross(matched.points_m - source_pose.position_m, n)
    by_target = -np.cross(matched.points_m - target_pose.position_m, n)
    return np.hstack([by_source, n, by_target, -n])
