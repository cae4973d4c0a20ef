"""Look for the placement of one surface on another, and for its rivals, from many starts."""

from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.rotations import rotation_from_vector
from tasks.registration.cloud_evidence import Explained, explained
from tasks.registration.cloud_fit import Fitted, Sampled, fit, sampled
from tasks.registration.cloud_motion import RigidMotion, typical_distance
from tasks.registration.cloud_starts import likely_starts
from tasks.registration.cloud_surface import Surface, thinned

THIN: Final = 4000
COARSE_QUERIES: Final = 600
FINE_QUERIES: Final = 1500
STARTS: Final = 16
DIFFERENT: Final = 0.04
"""Placements that put the moving points apart by less than this share of the extent are one."""

PURSUED: Final = 4
"""Placements of thin surfaces that are worth trying on the whole ones."""

NEARBY: Final = (0.07, 0.2)
"""Shifts in extents at which a neighbour that also fits is looked for: what repeats does so at such lengths."""

GATE_NOISES: Final = 3.0
LEAST_GATE_SPACINGS: Final = 0.1
"""A gate is never below this share of the spacing: perfect planes have no noise at all."""

FIRST_GATE: Final = 0.5
"""First gate from a start that is taken at its word, in extents; from a start of the search 0.2 of them."""


@dataclass(frozen=True, slots=True)
class Scene:
    """Two centred surfaces, whole and thin, with the gates that their noise sets; the unit is their extent."""

    fine: Sampled
    coarse: Sampled
    fine_gate: float
    coarse_gate: float


@dataclass(frozen=True, slots=True)
class Placement:
    """A placement that a search ended in, and what it explains."""

    motion: RigidMotion
    explained: Explained

    @property
    def score(self) -> float:
        """Mean credit over all queries."""
        return float(np.mean(self.explained.credit))


def scene_of(fixed: Surface, moving: Surface) -> Scene:
    """Prepare two surfaces for a search."""
    thin = sampled(thinned(fixed, THIN), thinned(moving, THIN), COARSE_QUERIES)
    fine = sampled(fixed, moving, FINE_QUERIES)
    return Scene(fine, thin, gate_of(fixed, moving), gate_of(thin.fixed, thin.moving))


def gate_of(fixed: Surface, moving: Surface) -> float:
    """How far along its normal a point may lie off a surface that it belongs to."""
    return max(
        GATE_NOISES * float(np.hypot(fixed.noise, moving.noise)),
        LEAST_GATE_SPACINGS * float(np.hypot(fixed.spacing, moving.spacing)),
    )


def place_from(scene: Scene, start: RigidMotion, first_gate: float) -> Placement | None:
    """Fit the thin surfaces, then the whole ones; None where too little finds a partner."""
    coarse = fit(scene.coarse, start, (first_gate, scene.coarse_gate), 30)
    end = None if coarse is None else _finer(scene, coarse)
    return None if end is None else placement_at(scene, end)


def search(scene: Scene) -> list[Placement]:
    """Placements that differ, the one that explains most first, from starts that likeness suggests."""
    starts = likely_starts(scene.coarse.fixed, scene.coarse.moving, STARTS, 0.1)
    return _distinct(scene, _through_thin(scene, starts))


def rivals_about(scene: Scene, placement: Placement, weakest: NDArray[np.float64]) -> list[Placement]:
    """Other placements near and about one, for what is symmetric or repeats.

    It is turned by quarters about the principal axes, and shifted all around in the plane of the two ``weakest``
    directions of shift (columns, (3, 2)).
    """
    points = scene.coarse.moving.points
    axes = np.linalg.eigh(np.cov(points.T)).eigenvectors
    middle = points.mean(axis=0)
    turned = []
    for axis, quarter in product(axes.T, (1, 2, 3)):
        turn = rotation_from_vector(0.5 * np.pi * quarter * axis)
        turned.append(_after(placement.motion, RigidMotion(turn, middle - turn @ middle)))
    ends = _through_thin(scene, turned)
    for angle, length in product(np.arange(8) * 0.25 * np.pi, NEARBY):
        shift = length * (weakest @ np.array([np.cos(angle), np.sin(angle)]))
        start = placement.motion.turned(np.zeros(3), shift)
        end = fit(scene.fine, start, (max(0.7 * length, scene.fine_gate), scene.fine_gate), 18)
        if end is not None:
            ends.append(end.motion)
    return _distinct(scene, [end for end in ends if not same(scene, end, placement.motion)])


def same(scene: Scene, one: RigidMotion, other: RigidMotion) -> bool:
    """Whether two placements are one."""
    return typical_distance(one, other, scene.coarse.moving.points) < DIFFERENT


def _after(outer: RigidMotion, inner: RigidMotion) -> RigidMotion:
    return RigidMotion(outer.rotation @ inner.rotation, outer.to_fixed(inner.translation[None])[0])


def _through_thin(scene: Scene, starts: list[RigidMotion]) -> list[RigidMotion]:
    """Where starts lead on the thin surfaces, and from there on the whole ones; only what is worth it goes on."""
    ends: list[tuple[float, Fitted]] = []
    for start in starts:
        end = fit(scene.coarse, start, (0.2, scene.coarse_gate), 18)
        if end is not None and not any(same(scene, end.motion, other.motion) for _, other in ends):
            worth = explained(scene.coarse, end.motion, scene.coarse_gate).credit
            ends.append((float(np.mean(worth)), end))
    ends.sort(key=lambda end: -end[0])
    finer = [_finer(scene, end) for _, end in ends[:PURSUED]]
    return [end for end in finer if end is not None]


def _finer(scene: Scene, coarse: Fitted) -> RigidMotion | None:
    gate = max(3.0 * coarse.sigma, scene.fine_gate)
    fine = fit(scene.fine, coarse.motion, (gate, scene.fine_gate), 18)
    return None if fine is None else fine.motion


def placement_at(scene: Scene, motion: RigidMotion) -> Placement:
    """A placement with what it explains."""
    return Placement(motion, explained(scene.fine, motion, scene.fine_gate))


def _distinct(scene: Scene, ends: list[RigidMotion]) -> list[Placement]:
    placements = sorted((placement_at(scene, end) for end in ends), key=lambda placement: -placement.score)
    kept: list[Placement] = []
    for placement in placements:
        if not any(same(scene, placement.motion, other.motion) for other in kept):
            kept.append(placement)
    return kept


def points_in_extents(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Centre (3,) of a cloud and its extent: the median distance from the centre."""
    centre = points.mean(axis=0)
    return centre, float(np.median(np.linalg.norm(points - centre, axis=1)))
