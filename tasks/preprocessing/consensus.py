"""Circles that the points of one height band agree on."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import tukey_weights

TRIALS: Final = 600
"""Triples of points tried a band: with 20 % of the points on the shaft five are all on it."""

FINALISTS: Final = 40
"""Circles with the most points for the fewest inside, of which the coverage is looked at."""

ANSWERS: Final = 3
"""Different circles kept a band; the linking of the bands decides among them."""

SECTORS: Final = 36
"""Parts of the circumference whose occupation is counted: a near and dense patch must not outvote the round."""

INSIDE_COST: Final = 3.0
"""How many points on the circle one point inside it takes back: a shaft has none inside."""


@dataclass(frozen=True, slots=True)
class CircleSearch:
    """Bounds of a search: radii (lowest, highest) and the half width of the ring that counts as on it, metres."""

    radius_window_m: tuple[float, float]
    tolerance_m: float


@dataclass(frozen=True, slots=True)
class Circles:
    """Circles (k, 3) as east, north, radius in metres, and their scores (k,) from 0 to 1, best first."""

    parameters_m: NDArray[np.float64]
    scores: NDArray[np.float64]


def find_circles(xy_m: NDArray[np.float64], search: CircleSearch, rng: np.random.Generator) -> Circles:
    """Find the circles that points (n, 2) agree on best, at most ``ANSWERS`` different ones.

    The score is the share of the circumference that is occupied, reduced by points inside.

    References
    ----------
    Fischler & Bolles 1981, Random sample consensus.
    """
    trials = _circles_through_triples(xy_m, rng)
    lo_m, hi_m = search.radius_window_m
    trials = trials[(trials[:, 2] >= lo_m) & (trials[:, 2] <= hi_m)]
    if not len(trials):
        return Circles(np.empty((0, 3)), np.empty(0))
    off_m = _distances(xy_m, trials) - trials[:, 2:]
    votes = _on(off_m, search).sum(axis=1) - INSIDE_COST * _inside(off_m, search).sum(axis=1)
    finalists = trials[np.argsort(-votes, kind="stable")[:FINALISTS]]
    chosen = _different(finalists, _scores(xy_m, finalists, search))
    refined = np.array([_refine(xy_m, circle, search.tolerance_m) for circle in chosen])
    refined = refined[(refined[:, 2] >= lo_m) & (refined[:, 2] <= hi_m)]
    scores = _scores(xy_m, refined, search)
    order = np.argsort(-scores, kind="stable")
    return Circles(refined[order], scores[order])


def _circles_through_triples(xy_m: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Circles (k, 3) through random triples of points (n, 2); collinear triples are left out."""
    picked = xy_m[rng.integers(0, len(xy_m), (TRIALS, 3))]
    b, c = picked[:, 1] - picked[:, 0], picked[:, 2] - picked[:, 0]
    cross = 2.0 * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    true_triple = np.abs(cross) > 1e-12
    b, c, cross, origin = b[true_triple], c[true_triple], cross[true_triple], picked[true_triple, 0]
    bb, cc = (b * b).sum(axis=1), (c * c).sum(axis=1)
    east = (c[:, 1] * bb - b[:, 1] * cc) / cross
    north = (b[:, 0] * cc - c[:, 0] * bb) / cross
    return np.column_stack([origin[:, 0] + east, origin[:, 1] + north, np.hypot(east, north)])


def _distances(xy_m: NDArray[np.float64], circles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances (k, n) of points (n, 2) from the centres of circles (k, 3)."""
    east, north = xy_m[None, :, 0] - circles[:, :1], xy_m[None, :, 1] - circles[:, 1:2]
    # lengths of metres cannot overflow, and this is three times as fast as hypot
    return np.asarray(np.sqrt(east * east + north * north))


def _on(off_m: NDArray[np.float64], search: CircleSearch) -> NDArray[np.bool_]:
    return np.abs(off_m) <= search.tolerance_m


def _inside(off_m: NDArray[np.float64], search: CircleSearch) -> NDArray[np.bool_]:
    return off_m < -3.0 * search.tolerance_m


def _scores(
    xy_m: NDArray[np.float64], circles: NDArray[np.float64], search: CircleSearch
) -> NDArray[np.float64]:
    """Share of the circumference occupied (k,), times the share of points that are not inside."""
    off_m = _distances(xy_m, circles) - circles[:, 2:]
    on = _on(off_m, search)
    angle = np.arctan2(xy_m[None, :, 1] - circles[:, 1:2], xy_m[None, :, 0] - circles[:, :1])
    sector = np.floor((angle / (2.0 * np.pi) + 0.5) * SECTORS).astype(np.int64) % SECTORS
    cell = np.arange(len(circles))[:, None] * SECTORS + sector
    occupied = np.bincount(cell[on], minlength=len(circles) * SECTORS).reshape(-1, SECTORS) > 0
    purity = 1.0 - INSIDE_COST * _inside(off_m, search).sum(axis=1) / np.maximum(on.sum(axis=1), 1)
    return np.asarray(occupied.mean(axis=1) * np.maximum(purity, 0.0))


def _different(circles: NDArray[np.float64], scores: NDArray[np.float64]) -> NDArray[np.float64]:
    """Best circles (at most ``ANSWERS``, 3) whose centres or radii differ by more than 0.3 radii."""
    chosen: list[NDArray[np.float64]] = []
    for index in np.argsort(-scores, kind="stable"):
        circle = circles[index]
        if all(np.max(np.abs(circle - other)) > 0.3 * other[2] for other in chosen):
            chosen.append(circle)
        if len(chosen) == ANSWERS:
            break
    return np.array(chosen)


def _refine(
    xy_m: NDArray[np.float64], circle: NDArray[np.float64], tolerance_m: float
) -> NDArray[np.float64]:
    """Move a circle (3,) to the points near it by weighted geometric least squares."""
    for _ in range(5):
        ray = xy_m - circle[:2]
        distance_m = np.maximum(np.hypot(ray[:, 0], ray[:, 1]), 1e-9)
        weights = tukey_weights(distance_m - circle[2], tolerance_m, cut=2.0)
        design = np.column_stack([ray / distance_m[:, None], np.ones(len(ray))]) * np.sqrt(weights)[:, None]
        # a little damping towards the start keeps short arcs from running away
        normal = design.T @ design + 1e-3 * np.eye(3)
        circle = circle + np.linalg.solve(normal, design.T @ (np.sqrt(weights) * (distance_m - circle[2])))
    return circle
