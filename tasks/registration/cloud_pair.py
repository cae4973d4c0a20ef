"""Register one cloud onto another of any unit and size without a prior, and say whether to believe the result."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.registration.cloud_directions import observability, untangled, with_unseen_unknown
from tasks.registration.cloud_evidence import Knowledge, knowledge, two_sided_difference, won_back
from tasks.registration.cloud_fit import Fitted, Sampled, fit, joined, sampled
from tasks.registration.cloud_motion import RigidMotion, typical_distance
from tasks.registration.cloud_result import PairRegistration, Rival, doubts
from tasks.registration.cloud_search import (
    FIRST_GATE,
    GATE_NOISES,
    Placement,
    Scene,
    place_from,
    placement_at,
    points_in_extents,
    rivals_about,
    same,
    scene_of,
    search,
)
from tasks.registration.cloud_surface import surface_of

MIN_POINTS: Final = 100
MAX_POINTS: Final = 200_000
"""A larger cloud is thinned to this many points, evenly in the order of the file."""

MIN_SURFACE: Final = 50
"""Points with a normal, of thousands, that each cloud must have before anything is fitted."""

FINAL_QUERIES: Final = 20_000
FINAL_ITERATIONS: Final = 60


def register_pair(
    fixed_points: NDArray[np.float64], moving_points: NDArray[np.float64], start: RigidMotion | None = None
) -> PairRegistration:
    """Place a cloud on another one and weigh the evidence for it.

    With a ``start`` the placement is the one that it leads to; without, the best of a seeded search and of the clouds
    as they lie. In either case the placements found elsewhere are held against it. The result is deterministic.
    Surfaces are needed: what has no normals, such as foliage, takes no part.

    Parameters
    ----------
    fixed_points, moving_points : (n, 3) and (m, 3) arrays
        Two clouds in one unit, whatever it is, each in its own frame.
    start : RigidMotion, optional
        T_fixed_moving, roughly: within about half the radius of the cloud.

    Returns
    -------
    PairRegistration
        With ``state`` "not trustworthy" and the reasons unless everything speaks for the placement.

    Raises
    ------
    ShapeError
        If an array is not (n, 3), not finite, or has fewer than 100 distinct points.

    References
    ----------
    Chen & Medioni 1992 (point to plane); Rusu, Blodow & Beetz 2009 (likeness of neighbourhoods); Liang & Zeger 1986
    (sandwich covariance of clusters).
    """
    fixed, moving = _distinct("fixed", fixed_points), _distinct("moving", moving_points)
    fixed_centre, fixed_extent = points_in_extents(fixed)
    moving_centre, moving_extent = points_in_extents(moving)
    unit = float(np.sqrt(fixed_extent * moving_extent))
    scene = scene_of(surface_of((fixed - fixed_centre) / unit), surface_of((moving - moving_centre) / unit))
    frames = _Frames(fixed_centre, moving_centre, unit)
    given = frames.inward(start or RigidMotion(np.eye(3), np.zeros(3)))
    found = _placements(scene, given, stated=start is not None)
    if not found:
        return _nothing(frames, given, scene)
    final = _finish(scene, found[0])
    if final is None:
        return _nothing(frames, found[0].motion, scene)
    known = untangled(knowledge(_whole(scene), final))
    best = placement_at(scene, final.motion)
    others = [*found[1:], *rivals_about(scene, best, _weakest_shifts(final))]
    return _weighed(_Weighing(frames, scene, final, known, best, _strongest(scene, best, others)))


@dataclass(frozen=True, slots=True)
class _Frames:
    """Inside, both clouds are about their own centres and the unit is their extent."""

    fixed_centre: NDArray[np.float64]
    moving_centre: NDArray[np.float64]
    unit: float

    def inward(self, motion: RigidMotion) -> RigidMotion:
        placed = motion.to_fixed(self.moving_centre[None])[0]
        return RigidMotion(motion.rotation, (placed - self.fixed_centre) / self.unit)

    def outward(self, motion: RigidMotion) -> RigidMotion:
        placed = self.fixed_centre + self.unit * motion.translation
        return RigidMotion(motion.rotation, placed - motion.rotation @ self.moving_centre)


def _distinct(name: str, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points without copies, in their order: coordinates on a grid fall together and would have no spacing."""
    if points.ndim != 2 or points.shape[1] != 3 or not np.all(np.isfinite(points)):
        raise ShapeError(f"register_pair needs finite {name} points (n, 3); got shape {points.shape}")
    first = np.sort(np.unique(points, axis=0, return_index=True)[1])
    if len(first) < MIN_POINTS:
        raise ShapeError(f"register_pair needs {MIN_POINTS} distinct {name} points; got {len(first)}")
    if len(first) > MAX_POINTS:
        first = first[np.linspace(0, len(first) - 1, MAX_POINTS).astype(np.int64)]
    return np.asarray(points[first], dtype=np.float64)


def _placements(scene: Scene, given: RigidMotion, stated: bool) -> list[Placement]:
    """What the given start leads to and what a search finds; the stated start's end comes first, else the best."""
    if min(len(scene.coarse.fixed.points), len(scene.coarse.moving.points)) < MIN_SURFACE:
        return []
    begun = place_from(scene, given, FIRST_GATE)
    if stated and begun is None:
        return []
    found = search(scene)
    if begun is None:
        return found
    others = [placement for placement in found if not same(scene, placement.motion, begun.motion)]
    if stated:
        return [begun, *others]
    return sorted([begun, *others], key=lambda placement: -placement.score)


def _finish(scene: Scene, placement: Placement) -> Fitted | None:
    """Match many points at the tightest gate until nothing moves: clouds without noise come out exact."""
    return fit(_whole(scene), placement.motion, (scene.fine_gate, scene.fine_gate), FINAL_ITERATIONS)


def _whole(scene: Scene) -> Sampled:
    return sampled(scene.fine.fixed, scene.fine.moving, FINAL_QUERIES)


def _weakest_shifts(final: Fitted) -> NDArray[np.float64]:
    """The two directions (3, 2) of shift that the fewest planes oppose."""
    normals = joined(final.matches).normals
    return np.asarray(np.linalg.eigh(normals.T @ normals).eigenvectors[:, :2])


@dataclass(frozen=True, slots=True)
class _Weighing:
    frames: "_Frames"
    scene: Scene
    final: Fitted
    known: Knowledge
    best: Placement
    rival: tuple[Placement, float] | None


def _strongest(scene: Scene, best: Placement, others: list[Placement]) -> tuple[Placement, float] | None:
    rivals = [
        (other, won_back(best.explained, other.explained))
        for other in others
        if not same(scene, other.motion, best.motion)
    ]
    return max(rivals, key=lambda rival: rival[1], default=None)


def _weighed(this: _Weighing) -> PairRegistration:
    frames, final, known, best = this.frames, this.final, this.known, this.best
    pair = _whole(this.scene)
    residuals = np.concatenate([matches.residuals for matches in final.matches])
    covariance = with_unseen_unknown(known, 1.0)
    two_sided = two_sided_difference(pair, final, this.scene.fine_gate)
    unit, scale = frames.unit, np.r_[np.ones(3), np.full(3, frames.unit)]
    result = PairRegistration(
        T_fixed_moving=frames.outward(final.motion),
        centre=frames.fixed_centre + unit * final.motion.translation,
        covariance=covariance * np.outer(scale, scale),
        overlap_moving=best.explained.overlap[0],
        overlap_fixed=best.explained.overlap[1],
        rms=unit * float(np.sqrt(np.mean(residuals**2))),
        sigma=unit * final.sigma,
        touching_sigma=unit * best.explained.sigma,
        noise=unit * this.scene.fine_gate / GATE_NOISES,
        spacing=unit * max(pair.fixed.spacing, pair.moving.spacing),
        agreement=best.explained.agreement,
        two_sided=None if two_sided is None else unit * two_sided,
        observability=observability(known, covariance, unit, len(residuals) / final.sigma**2),
        rival=None if this.rival is None else _rival(this, *this.rival),
        state="not trustworthy",
        reasons=(),
        n_iterations=final.iterations,
    )
    reasons = doubts(result)
    if not final.converged:
        reasons = (*reasons, f"the fit still moved after {final.iterations} iterations")
    return replace(result, reasons=reasons, state="not trustworthy" if reasons else "ok")


def _rival(this: _Weighing, other: Placement, share: float) -> Rival:
    away = typical_distance(other.motion, this.final.motion, this.scene.coarse.moving.points)
    return Rival(this.frames.outward(other.motion), this.frames.unit * away, share)


def _nothing(frames: _Frames, motion: RigidMotion, scene: Scene) -> PairRegistration:
    """The start itself, said to be worth nothing: no fit could be made of it."""
    placed = frames.outward(motion)
    fixed, moving = scene.fine.fixed, scene.fine.moving
    return PairRegistration(
        T_fixed_moving=placed,
        centre=placed.to_fixed(frames.moving_centre[None])[0],
        covariance=np.diag(np.full(6, np.inf)),
        overlap_moving=0.0,
        overlap_fixed=0.0,
        rms=None,
        sigma=None,
        touching_sigma=None,
        noise=frames.unit * scene.fine_gate / GATE_NOISES,
        spacing=frames.unit * max(fixed.spacing, moving.spacing),
        agreement=0.0,
        two_sided=None,
        observability=None,
        rival=None,
        state="not trustworthy",
        reasons=(
            f"nothing could be fitted: {len(fixed.points)} fixed and {len(moving.points)} moving points have a "
            "surface about them, and too few of them find a partner; the motion is that of the start",
        ),
        n_iterations=0,
    )
