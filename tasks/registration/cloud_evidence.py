"""What a fit of two surfaces rests on: what it explains, what it leaves unseen, and how far it may be off."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import TUKEY_1D, mad_sigma
from tasks.registration.cloud_fit import MIN_MATCHES, Fitted, Matches, Sampled, fit, joined, match_both
from tasks.registration.cloud_motion import RigidMotion, typical_distance

BLOCKS: Final = 200
"""Patches of the surface whose residuals are taken as one: neighbours share the noise of their planes."""

WIDE: Final = 4.0
"""Gates within which a point touches the other surface; between one and this many it contradicts it."""


@dataclass(frozen=True, slots=True)
class Explained:
    """How much of both surfaces a placement explains, each between 0 and 1.

    ``credit`` are one value for each query of the moving, then of the fixed surface: 1 on the other surface, 0 off it.
    ``overlap`` are the shares that match, of the moving and of the fixed surface; ``agreement`` is the share that
    matches of what touches the other surface; ``sigma`` the robust scale of all residuals that touch.
    """

    credit: NDArray[np.float64]
    overlap: tuple[float, float]
    agreement: float
    sigma: float


def explained(pair: Sampled, motion: RigidMotion, gate: float) -> Explained:
    """Weigh a placement at residuals up to ``gate``."""
    sizes = (len(pair.moving_queries), len(pair.fixed_queries))
    touching = match_both(pair, motion, WIDE * gate)
    gained, shares = [], []
    for matches, size in zip(touching, sizes, strict=True):
        credit = np.zeros(size)
        credit[matches.query] = np.maximum(1.0 - (matches.residuals / gate) ** 2, 0.0)
        gained.append(credit)
        shares.append(float(np.mean(credit > 0.0)))
    n_touching = sum(len(matches.query) for matches in touching)
    credit = np.concatenate(gained)
    return Explained(
        credit,
        (shares[0], shares[1]),
        float(np.sum(credit > 0.0)) / n_touching if n_touching else 0.0,
        mad_sigma(joined(touching).residuals) if n_touching else 0.0,
    )


def won_back(best: Explained, rival: Explained) -> float:
    """What a rival explains and the best does not, as a share of what the best explains and the rival does not.

    What both explain, such as a floor under either placement, is no evidence and does not count.
    """
    difference = best.credit - rival.credit
    won = float(np.sum(np.maximum(difference, 0.0)))
    lost = float(np.sum(np.maximum(-difference, 0.0)))
    return lost / won if won > 0.0 else np.inf


@dataclass(frozen=True, slots=True)
class Knowledge:
    """Covariance (6, 6) of a rotation about the moving cloud's centroid, then a shift, fixed axes; and what is seen.

    ``seen`` (6,) ascending: mean square of how far the matched surfaces move along their normals for a unit of motion
    along each of ``directions`` (columns, rotations times ``lever``); 0 is unseen, independent of noise.
    """

    covariance: NDArray[np.float64]
    seen: NDArray[np.float64]
    directions: NDArray[np.float64]
    lever: float


def knowledge(pair: Sampled, fitted: Fitted) -> Knowledge:
    """Covariance from the scatter of whole patches, and what the normals of both surfaces agree on seeing.

    A patch is one observation, so that neighbouring residuals, and a pair that is found from both sides, count once
    (the sandwich estimator for clusters).
    """
    both = joined(fitted.matches)
    centre = fitted.motion.translation
    lever = float(np.sqrt(np.mean(np.sum((both.moving - centre) ** 2, axis=1))))
    scale = np.r_[np.full(3, 1.0 / lever), np.ones(3)]
    jacobian = both.jacobian(centre) * scale
    u = np.clip(np.abs(both.residuals) / (TUKEY_1D * fitted.sigma), 0.0, 1.0)
    bread = np.mean((1.0 - u**2) * (1.0 - 5.0 * u**2)) * (jacobian.T @ jacobian)
    scores = jacobian * ((1.0 - u**2) ** 2 * both.residuals)[:, None]
    sums = np.zeros((BLOCKS, 6))
    np.add.at(sums, _patches(pair, fitted.motion, both), scores)
    n_patches = int(np.count_nonzero(np.any(sums != 0.0, axis=1)))
    meat = sums.T @ sums * (n_patches / max(n_patches - 6, 1))
    inverse = np.linalg.pinv(bread, rcond=1e-12, hermitian=True)
    covariance = inverse @ meat @ inverse * np.outer(scale, scale)
    seen, directions = _seen(both, jacobian, centre, scale)
    return Knowledge(covariance, seen, directions, lever)


def _seen(
    both: Matches, jacobian: NDArray[np.float64], centre: NDArray[np.float64], scale: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    # the noise of a normal makes a bare cylinder look turnable by its square; that of two surfaces is independent
    sign = np.sign(np.einsum("ij,ij->i", both.normals, both.own_normals))[:, None]
    own = (
        np.hstack([np.cross(both.moving - centre, sign * both.own_normals), sign * both.own_normals]) * scale
    )
    product = jacobian.T @ own / len(jacobian)
    values, vectors = np.linalg.eigh(0.5 * (product + product.T))
    return values, vectors


def _patches(pair: Sampled, motion: RigidMotion, both: Matches) -> NDArray[np.int64]:
    from scipy.spatial import KDTree  # noqa: PLC0415 (slow to import)

    seeds = motion.to_fixed(pair.moving.points[pair.moving.sample(BLOCKS)])
    return np.asarray(KDTree(seeds).query(both.moving)[1], dtype=np.int64)


def two_sided_difference(pair: Sampled, fitted: Fitted, gate: float) -> float | None:
    """How far apart (rms over the matched points) the fits of A onto B and of B onto A end; None if one fails."""
    none = np.empty(0, dtype=np.int64)
    ends = []
    for queries in ((none, pair.moving_queries), (pair.fixed_queries, none)):
        one = fit(Sampled(pair.fixed, pair.moving, *queries), fitted.motion, (gate, gate), 15)
        if one is None:
            return None
        ends.append(one.motion)
    matched = fitted.motion.inverse().to_fixed(joined(fitted.matches).moving)
    return typical_distance(ends[0], ends[1], matched) if len(matched) >= MIN_MATCHES else None
