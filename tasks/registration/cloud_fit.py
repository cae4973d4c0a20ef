"""Fit one surface onto another from a start: point-to-plane distances both ways, robust, with shrinking gates."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import mad_sigma, tukey_weights
from tasks.registration.cloud_motion import RigidMotion
from tasks.registration.cloud_surface import Surface

NORMAL_COSINE: Final = float(np.cos(np.radians(40.0)))
MIN_MATCHES: Final = 12
SHRINK: Final = 0.75
LEAST_SIGMA: Final = 0.1
"""No residual is believed better than this share of the surfaces' own noise: a floor on the grid of its coordinates has
no residuals at all and would cast out every wall."""

SMALL_STEP: Final = 0.01
"""Converged when a step is below this share of the formal standard deviation in every direction."""

REACH_SPACINGS: Final = 2.0
"""A plane holds for this many spacings about the point that stands for it."""


@dataclass(frozen=True, slots=True)
class Matches:
    """Pairs of points and planes in the fixed frame: ``residuals = normals . (points - partners)``.

    ``moving`` are the points of the moving cloud, ``normals`` (n, 3) those of the planes and ``own_normals`` those at
    the other end of each pair. ``query`` says which sampled point made the pair.
    """

    moving: NDArray[np.float64]
    normals: NDArray[np.float64]
    own_normals: NDArray[np.float64]
    residuals: NDArray[np.float64]
    query: NDArray[np.int64]

    def jacobian(self, centre: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivatives (n, 6) of the residuals by a rotation about ``centre``, then a shift."""
        return np.hstack([np.cross(self.moving - centre, self.normals), self.normals])


@dataclass(frozen=True, slots=True)
class Sampled:
    """Two surfaces with the points (indices) of each that look for a partner in the other."""

    fixed: Surface
    moving: Surface
    fixed_queries: NDArray[np.int64]
    moving_queries: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Fitted:
    """Where a fit ended; ``matches`` are of the moving and of the fixed cloud's queries, in this order."""

    motion: RigidMotion
    matches: tuple[Matches, Matches]
    sigma: float
    iterations: int
    converged: bool


def sampled(fixed: Surface, moving: Surface, n: int) -> Sampled:
    """Let ``n`` points of each surface look for partners."""
    return Sampled(fixed, moving, fixed.sample(n), moving.sample(n))


def match_both(pair: Sampled, motion: RigidMotion, gate: float) -> tuple[Matches, Matches]:
    """Match moving points to fixed planes, and fixed points to moving planes, within ``gate`` along the normal."""
    placed = motion.to_fixed(pair.moving.points[pair.moving_queries])
    turned = pair.moving.normals[pair.moving_queries] @ motion.rotation.T
    forth = _nearest(placed, turned, pair.fixed, gate)
    back = motion.inverse()
    local = back.to_fixed(pair.fixed.points[pair.fixed_queries])
    local_normals = pair.fixed.normals[pair.fixed_queries] @ back.rotation.T
    found = _nearest(local, local_normals, pair.moving, gate)
    moving = motion.to_fixed(local[found.query] - found.residuals_vector)
    backward = Matches(
        moving,
        found.normals @ motion.rotation.T,
        found.own_normals @ motion.rotation.T,
        -found.residuals,
        found.query,
    )
    return Matches(
        placed[forth.query], forth.normals, forth.own_normals, forth.residuals, forth.query
    ), backward


@dataclass(frozen=True, slots=True)
class _Near:
    normals: NDArray[np.float64]
    own_normals: NDArray[np.float64]
    residuals: NDArray[np.float64]
    residuals_vector: NDArray[np.float64]
    query: NDArray[np.int64]


def _nearest(
    points: NDArray[np.float64], normals: NDArray[np.float64], target: Surface, gate: float
) -> _Near:
    reach = float(np.hypot(gate, REACH_SPACINGS * target.spacing))
    distance, index = target.tree.query(points, distance_upper_bound=reach)
    query = np.flatnonzero(np.isfinite(distance))
    planes, partners = target.normals[index[query]], target.points[index[query]]
    apart = points[query] - partners
    residuals = np.einsum("ij,ij->i", planes, apart)
    alike = np.abs(np.einsum("ij,ij->i", planes, normals[query])) > NORMAL_COSINE
    # beside a surface there is no plane: a pair must not be farther apart along it than points of its own stand
    lengths = np.maximum(target.lengths[index[query]], target.spacing)
    beside = np.sum(apart * apart, axis=1) - residuals**2 > (REACH_SPACINGS * lengths) ** 2 + gate**2
    good = alike & ~beside & (np.abs(residuals) <= gate)
    return _Near(planes[good], normals[query][good], residuals[good], apart[good], query[good])


def joined(matches: tuple[Matches, Matches]) -> Matches:
    """Both ways in one; queries of the fixed cloud are counted on after those of the moving one."""
    one, other = matches
    return Matches(
        np.vstack([one.moving, other.moving]),
        np.vstack([one.normals, other.normals]),
        np.vstack([one.own_normals, other.own_normals]),
        np.r_[one.residuals, other.residuals],
        np.r_[one.query, other.query],
    )


def solve_step(
    matches: Matches, centre: NDArray[np.float64], floor: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """One robust Gauss-Newton step (6,), its normal matrix (6, 6) per unit variance, and the residuals' sigma."""
    sigma = max(mad_sigma(matches.residuals), floor)
    weights = tukey_weights(matches.residuals, sigma)
    jacobian = matches.jacobian(centre)
    normal = (jacobian * weights[:, None]).T @ jacobian
    # a direction that nothing holds must not run away: it is held at a part in 1e9 of the best known one
    held = normal + 1e-9 * np.trace(normal) * np.eye(6)
    step = -np.linalg.solve(held, jacobian.T @ (weights * matches.residuals))
    return step, held, sigma


def fit(pair: Sampled, start: RigidMotion, gates: tuple[float, float], iterations: int) -> Fitted | None:
    """Gauss-Newton from ``start``, with a gate that shrinks from the first to the second of ``gates``.

    The moving cloud's origin is its centre. None where fewer than 12 points find a partner.
    """
    motion, gate = start, gates[0]
    floor = LEAST_SIGMA * float(np.hypot(pair.fixed.noise, pair.moving.noise))
    floor = max(floor, 1e-12 * float(np.max(np.abs(pair.fixed.points), initial=0.0)))
    sigma, converged, done = 0.0, False, 0
    while done < iterations and not converged:
        done += 1
        matches = match_both(pair, motion, gate)
        both = joined(matches)
        if len(both.residuals) < MIN_MATCHES:
            return None
        step, normal, sigma = solve_step(both, motion.translation, floor)
        motion = motion.turned(step[:3], step[3:])
        formal = float(np.sqrt(step @ normal @ step)) / max(sigma, floor)
        converged = gate <= gates[1] and formal < SMALL_STEP * np.sqrt(6.0)
        gate = max(SHRINK * gate, gates[1])
    return Fitted(motion, match_both(pair, motion, gates[1]), sigma, done, converged)
