"""Where a registration may begin when nothing is known: placements that put like neighbourhoods on each other."""

from itertools import permutations, product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.registration.cloud_motion import RigidMotion, typical_distance
from tasks.registration.cloud_surface import Surface

SEED: Final = 20250221
BINS: Final = 7
POINTS: Final = 1500
"""Points of each cloud that are described."""

ALIKE: Final = 3
"""Points of the other cloud that each point takes for its like."""

TRIALS: Final = 400_000
PLACEMENTS: Final = 20_000
CELLS: Final = 96
"""Cells along the longest side of the occupancy grid on which placements are ranked."""

RANKED: Final = 150
"""Points that are put on the grid for each placement."""


def likely_starts(fixed: Surface, moving: Surface, n: int, apart: float) -> list[RigidMotion]:
    """At most ``n`` placements, best first, at least ``apart`` from each other (rms over the moving points).

    Made of pairs of points whose neighbourhoods look alike, and of the principal axes laid on each other. The random
    choice of pairs is seeded. Both surfaces are centred, thin, and of one unit.
    """
    rotations, translations = _axes_on_axes(fixed.points, moving.points)
    found = _pairs_on_pairs(fixed, moving)
    rotations = np.concatenate([rotations, found[0]])
    translations = np.concatenate([translations, found[1]])
    shown = moving.points[moving.sample(RANKED)]
    order = np.argsort(-_ranks(fixed.points, shown, rotations, translations), kind="stable")
    chosen: list[RigidMotion] = []
    for i in order[: 40 * n]:
        motion = RigidMotion(rotations[i], translations[i])
        if all(typical_distance(motion, other, shown) > apart for other in chosen):
            chosen.append(motion)
        if len(chosen) == n:
            break
    return chosen


def _axes_on_axes(
    fixed: NDArray[np.float64], moving: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    ours, theirs = (np.linalg.eigh(np.cov(points.T)).eigenvectors for points in (fixed, moving))
    turns = []
    for order, signs in product(permutations(range(3)), product((-1.0, 1.0), repeat=3)):
        rotation = ours[:, order] @ np.diag(signs) @ theirs.T
        if np.linalg.det(rotation) > 0.0:
            turns.append(rotation)
    rotations = np.array(turns)
    shift = np.median(fixed, axis=0) - np.einsum("nij,j->ni", rotations, np.median(moving, axis=0))
    return rotations, shift


def _descriptors(surface: Surface, chosen: NDArray[np.int64], radius: float) -> NDArray[np.float64]:
    """Histograms (k, 6 BINS) of how normals and directions lie about each point, blind to the normals' signs."""
    parts = []
    for reach in (0.5 * radius, radius):
        distance, index = surface.tree.query(surface.points[chosen], k=64, distance_upper_bound=reach)
        there = np.isfinite(distance) & (distance > 0.0)
        index = np.where(there, index, 0)
        apart = surface.points[index] - surface.points[chosen][:, None, :]
        direction = apart / np.where(there, distance, 1.0)[:, :, None]
        own, other = surface.normals[chosen][:, None, :], surface.normals[index]
        angles = (
            np.abs(np.sum(own * other, axis=2)),
            np.abs(np.sum(own * direction, axis=2)),
            np.abs(np.sum(other * direction, axis=2)),
        )
        parts += [_histogram(angle, there) for angle in angles]
    return np.hstack(parts)


def _histogram(cosines: NDArray[np.float64], there: NDArray[np.bool_]) -> NDArray[np.float64]:
    # equal steps of the angle, not of its cosine
    cell = np.minimum((np.arccos(np.clip(cosines, 0.0, 1.0)) * BINS * 2.0 / np.pi).astype(np.int64), BINS - 1)
    counts = np.stack([np.sum((cell == i) & there, axis=1) for i in range(BINS)], axis=1)
    return np.asarray(np.sqrt(counts / np.maximum(there.sum(axis=1, keepdims=True), 1)))


def _pairs_on_pairs(fixed: Surface, moving: Surface) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rotations (k, 3, 3) and translations (k, 3) that lay two points with normals on two like ones."""
    from scipy.spatial import KDTree  # noqa: PLC0415 (slow to import)

    radius = 8.0 * max(fixed.spacing, moving.spacing) / np.sqrt(2.0)
    ours, theirs = fixed.sample(POINTS), moving.sample(POINTS)
    mine, other = _descriptors(fixed, ours, radius), _descriptors(moving, theirs, radius)
    near = KDTree(mine).query(other, k=ALIKE)[1]
    back = KDTree(other).query(mine, k=ALIKE)[1]
    p = np.r_[np.repeat(theirs, ALIKE), theirs[back.ravel()]]
    q = np.r_[ours[near.ravel()], np.repeat(ours, ALIKE)]
    rng = np.random.default_rng(SEED)
    one, two = rng.integers(len(p), size=(2, TRIALS))
    size = float(np.median(np.linalg.norm(moving.points, axis=1)))
    kept = _congruent((moving, p[one], p[two]), (fixed, q[one], q[two]), 0.5 * size, 0.05 * size)[:PLACEMENTS]
    a, b, c, d = p[one][kept], p[two][kept], q[one][kept], q[two][kept]
    source = _frames(moving.points[b] - moving.points[a], moving.normals[a])
    rotations, shifts = [], []
    for sign in (1.0, -1.0):
        target = _frames(fixed.points[d] - fixed.points[c], sign * fixed.normals[c])
        turn = np.einsum("nij,nkj->nik", target, source)
        middle = 0.5 * (moving.points[a] + moving.points[b])
        rotations.append(turn)
        shifts.append(0.5 * (fixed.points[c] + fixed.points[d]) - np.einsum("nij,nj->ni", turn, middle))
    return np.concatenate(rotations), np.concatenate(shifts)


def _congruent(
    source: tuple[Surface, NDArray[np.int64], NDArray[np.int64]],
    target: tuple[Surface, NDArray[np.int64], NDArray[np.int64]],
    shortest: float,
    tolerance: float,
) -> NDArray[np.int64]:
    """Indices of the pairs of points that lie to each other as the pairs that they shall cover."""
    figures = []
    for surface, first, second in (source, target):
        apart = surface.points[second] - surface.points[first]
        length = np.linalg.norm(apart, axis=1)
        along = apart / np.maximum(length, 1e-300)[:, None]
        n, m = surface.normals[first], surface.normals[second]
        angles = [np.abs(np.sum(x * y, axis=1)) for x, y in ((n, m), (n, along), (m, along))]
        figures.append((length, np.arccos(np.clip(angles, 0.0, 1.0))))
    (length, angles), (other_length, other_angles) = figures
    good = (length > shortest) & (np.abs(length - other_length) < tolerance)
    # 12 degrees: thin clouds know their normals no better
    good &= np.all(np.abs(angles - other_angles) < 0.2, axis=0) & (angles[1] > 0.3)
    return np.flatnonzero(good)


def _frames(along: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Right-handed frames (n, 3, 3), columns: along, across, and what is left of the normal."""
    x = along / np.linalg.norm(along, axis=1, keepdims=True)
    z = normal - np.sum(normal * x, axis=1, keepdims=True) * x
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)


def _ranks(
    fixed: NDArray[np.float64],
    shown: NDArray[np.float64],
    rotations: NDArray[np.float64],
    translations: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Share (k,) of the shown points that fall near the fixed ones."""
    low = fixed.min(axis=0)
    cell = float(np.max(fixed.max(axis=0) - low)) / CELLS
    grid = np.zeros((CELLS + 3,) * 3, dtype=bool)
    at = ((fixed - low) / cell).astype(np.int64) + 1
    for step in product((-1, 0, 1), repeat=3):
        grid[tuple((at + step).T)] = True
    ranks = np.empty(len(rotations))
    for some in np.array_split(np.arange(len(rotations)), max(1, len(rotations) // 2000)):
        placed = np.einsum("nij,mj->nmi", rotations[some], shown) + translations[some][:, None, :]
        where = np.clip(np.floor((placed - low) / cell).astype(np.int64) + 1, 0, CELLS + 2)
        inside = np.all((where > 0) & (where < CELLS + 2), axis=2)
        ranks[some] = np.mean(grid[where[..., 0], where[..., 1], where[..., 2]] & inside, axis=1)
    return ranks
