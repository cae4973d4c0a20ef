"""Compare two placed scans: point-to-plane residuals with their derivatives by both poses."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import mad_sigma
from tasks.registration.partners import Partners
from tasks.registration.planar import PlanarCloud
from tasks.registration.station import StationPose

NORMAL_COSINE: Final = float(np.cos(np.radians(25.0)))
MIN_SIGMA_M: Final = 0.006
MIN_MATCHES: Final = 12
CORRELATION: Final = 13.0
"""Neighbouring residuals are not independent: their information is divided by this. Chosen so that simulated
poses scatter about their truth as their covariance says (8 and 3 stations, 60,000 and 200,000 points each)."""


@dataclass(frozen=True, slots=True)
class PlacedPlanes:
    """Points (m, 3) and unit normals (m, 3) in the site frame, of planes ``index`` (m,) of a cloud that ``pose`` placed."""

    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    cloud: PlanarCloud
    index: NDArray[np.int64]
    pose: StationPose

    @property
    def tilts(self) -> NDArray[np.float64]:
        """Tilts of the normals (m, 2, 3), in the site frame."""
        own = self.cloud.tilts[self.index]
        return np.asarray((own.reshape(-1, 3) @ self.pose.rotation.T).reshape(-1, 2, 3))


@dataclass(frozen=True, slots=True)
class Matches:
    """Planes of the source and those of the target that they lie in, one for one, and their distances (m,).

    ``sigma_m`` is the robust scale of the distances, not below 6 mm; None with too few matches.
    """

    source: PlacedPlanes
    target: PlacedPlanes
    residuals_m: NDArray[np.float64]
    n_queries: int
    sigma_m: float | None


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
    """Find the planes of the target that planes of the source lie in; as ``match_partners``."""
    return match_partners(Partners(source, target), source, source_pose, target_pose, gate_m)


def match_partners(
    partners: Partners, source: PlanarCloud, source_pose: StationPose, target_pose: StationPose, gate_m: float
) -> Matches:
    """Find the planes of the target that planes of the source lie in, among the nearest.

    A residual is (n_p + n_q) / 2 . (p - q) in the site frame, p and its normal moving with the source, q and its normal
    with the target. On a circle that is exactly zero wherever the partners lie on it, so that neither the bend of a shaft
    between two partners nor a turn about its axis looks like a distance.

    References
    ----------
    Rusinkiewicz 2019, A symmetric objective function for ICP, ACM Trans. Graph. 38.
    """
    from tasks.registration.match_kernel import good_matches  # noqa: PLC0415 (slow to import)

    target = partners.target
    # searched in the target's own frame, so that its tree is built once; the gate holds along the normal, because
    # the nearest target point lies up to its spacing away within the same plane
    reach_m = max(gate_m, target.reach_m)
    placed_m, nearest, distance = partners.nearest(source_pose, target_pose, reach_m)
    good, (own, places, planes), residuals = good_matches(
        placed_m,
        partners.normals,
        np.ascontiguousarray(source_pose.rotation),
        (nearest, distance),
        (target.points_m, target.normals),
        (np.ascontiguousarray(target_pose.rotation), target_pose.position_m),
        (reach_m, gate_m, NORMAL_COSINE),
    )
    return Matches(
        PlacedPlanes(placed_m[good], own, source, partners.asked[good], source_pose),
        PlacedPlanes(places, planes, target, nearest[good], target_pose),
        residuals,
        len(placed_m),
        None if len(residuals) < MIN_MATCHES else max(mad_sigma(residuals), MIN_SIGMA_M),
    )


def pair_equations(matches: Matches, source_pose: StationPose, target_pose: StationPose) -> PairEquations:
    """Linearise the residuals; Geman-McClure weights with the robust scale of the pair."""
    weight = match_weights(matches)
    if weight is None:
        return NO_EQUATIONS
    own, other = matches.source.normals, matches.target.normals
    return _summed(matches, (own, other), (source_pose, target_pose), weight)


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
    still = np.zeros_like(matches.source.normals)
    own, other = matches.source.tilts, matches.target.tilts
    for k in range(2):
        for tilts in ((own[:, k], still), (still, other[:, k])):
            total += _summed(matches, tilts, (source_pose, target_pose), weight).matrix
    return total


def _summed(
    matches: Matches,
    normals: tuple[NDArray[np.float64], NDArray[np.float64]],
    poses: tuple[StationPose, StationPose],
    weight: NDArray[np.float64],
) -> PairEquations:
    """Equations for given normals (m, 3) of source and target, in which the derivatives are linear."""
    from tasks.registration.match_kernel import normal_equations  # noqa: PLC0415 (slow to import)

    matrix, vector = normal_equations(
        matches.source.points_m,
        matches.target.points_m,
        np.ascontiguousarray(normals[0]),
        np.ascontiguousarray(normals[1]),
        (poses[0].position_m, poses[1].position_m),
        weight,
        matches.residuals_m,
    )
    return PairEquations(matrix, vector)


def match_weights(matches: Matches) -> NDArray[np.float64] | None:
    """Weights (m,) in 1 / m2; None with too few matches."""
    sigma = matches.sigma_m
    if sigma is None:
        return None
    robust = 1.0 / (1.0 + (matches.residuals_m / (3.0 * sigma)) ** 2) ** 2
    return np.asarray(robust / (sigma**2 * CORRELATION))


def derivatives(matches: Matches, source_pose: StationPose, target_pose: StationPose) -> NDArray[np.float64]:
    """Derivatives (m, 12) of the residuals by the poses of source and target."""
    return _derivatives_of(matches, matches.source.normals, matches.target.normals, source_pose, target_pose)


def _derivatives_of(
    matches: Matches,
    source_normals: NDArray[np.float64],
    target_normals: NDArray[np.float64],
    source_pose: StationPose,
    target_pose: StationPose,
) -> NDArray[np.float64]:
    """Derivatives (m, 12) for given normals (m, 3), in which they are linear."""
    p, q = matches.source.points_m, matches.target.points_m
    middle, half_apart = 0.5 * (source_normals + target_normals), 0.5 * (p - q)
    by_source = np.cross(p - source_pose.position_m, middle) + np.cross(source_normals, half_apart)
    by_target = -np.cross(q - target_pose.position_m, middle) + np.cross(target_normals, half_apart)
    return np.hstack([by_source, middle, by_target, -middle])
