"""The search for a shaft with four plane faces: planes that most height bands see, put together to a box."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.faces import split_by_face
from tasks.geometry.failure import FitFailure
from tasks.geometry.orientation import edge_directions
from tasks.preprocessing.bands import sample_bands
from tasks.preprocessing.face_lines import BandPoints, FaceLines, find_lines
from tasks.preprocessing.kinds import StructureKind
from tasks.preprocessing.prior import StructurePrior
from tasks.preprocessing.search import (
    POINTS_PER_BAND,
    POINTS_PER_BAND_MIN,
    TOLERANCE_FLOOR_M,
    TOLERANCE_RADII,
    reach_m,
)

SIDES: Final = 4

DIRECTIONS: Final = 4
"""Directions of edges that are tried: a long wall beside the tower may gather more points than its faces."""

VOTERS: Final = 80
"""Points of a band that judge a box: two a cell of the circumference."""

ENOUGH: Final = 0.6
"""Share of the circumference from which on no other direction is tried: only the tower itself shows so much."""

CELLS: Final = 9
"""Parts of a face whose occupation is counted: a near and dense patch must not outvote the whole."""

SHARE_NEEDED: Final = 0.35
"""Share of the circumference in evidence: two whole faces have 0.5, a round shaft touches four planes with 0.2."""

INSIDE_COST: Final = 3.0
"""How many points on the faces one point inside takes back: a shaft has none inside."""

UNSEEN_SIDES: Final = 10
"""Half sides tried where no two opposite faces are seen."""

PLACE_RADII: Final = 0.3
"""How far, in half sides, a rough box may be beyond the slack of the position: it is rough."""


@dataclass(frozen=True, slots=True)
class RoughFaces:
    """A box: azimuth (4,) of the normals, distance (2, 4) of the faces at the two ends of the shaft.

    The distances are counted from the prior's position, in metres, and are negative where that is outside.
    """

    azimuth_rad: NDArray[np.float64]
    distance_m: NDArray[np.float64]

    def at(self, z_m: NDArray[np.float64], shaft_z_m: tuple[float, float]) -> NDArray[np.float64]:
        """Distances (n, 4) at heights (n,), metres."""
        share = ((z_m - shaft_z_m[0]) / (shaft_z_m[1] - shaft_z_m[0]))[:, None]
        return np.asarray(self.distance_m[0] * (1.0 - share) + self.distance_m[1] * share)


def find_rough_faces(
    points_m: NDArray[np.float64], prior: StructurePrior, kind: StructureKind, rng: np.random.Generator
) -> RoughFaces | FitFailure:
    """Find a box with four plane faces, of which two adjacent ones at least are seen, among points (n, 3)."""
    seen = _sampled(points_m, prior, rng, POINTS_PER_BAND)
    wanted = (
        f"plane faces, half a side {kind.radius_window[0] * min(prior.radius_m):.2f} to "
        f"{kind.radius_window[1] * max(prior.radius_m):.2f} m, within {reach_m(prior, kind):.1f} m of base_xy_m "
        f"{prior.base_xy_m}"
    )
    if seen.n_bands == 0:
        return FitFailure(f"needed {wanted}; found no height band with {POINTS_PER_BAND_MIN} points")
    voters = _sampled(points_m, prior, rng, VOTERS)
    tolerance_m = _tolerance_m(prior)
    best, best_score, best_share = None, 0.0, 0.0
    for azimuth in edge_directions(seen.xy_m, seen.band, SIDES, 2.0 * tolerance_m, DIRECTIONS):
        if best_share >= ENOUGH:
            break
        lines = [find_lines(seen, azimuth + turn, prior, kind, tolerance_m) for turn in (0.0, np.pi / 2)]
        for distance_m in _boxes(lines, prior, kind):
            box = RoughFaces(azimuth + np.arange(SIDES) * np.pi / 2, distance_m)
            score, share = _score(box, voters, prior, tolerance_m)
            if score > best_score:
                best, best_score, best_share = box, score, share
    if best is None or best_share < SHARE_NEEDED:
        return FitFailure(
            f"needed {wanted}, that hold points on {SHARE_NEEDED:.0%} of the circumference; "
            f"the best four hold {best_share:.0%}"
        )
    return best


def _tolerance_m(prior: StructurePrior) -> float:
    return TOLERANCE_FLOOR_M + TOLERANCE_RADII * float(np.mean(prior.radius_m))


def _sampled(
    points_m: NDArray[np.float64], prior: StructurePrior, rng: np.random.Generator, per_band: int
) -> BandPoints:
    """Points of the bands that have enough, about the prior's position."""
    bands = sample_bands(points_m[:, 2], prior.band_edges_m(), per_band, rng)
    full = [rows for rows in bands if len(rows) >= POINTS_PER_BAND_MIN]
    rows = np.concatenate([np.empty(0, dtype=np.int64), *full])
    band = np.repeat(np.arange(len(full)), [len(one) for one in full])
    return BandPoints(points_m[rows, :2] - prior.base_xy_m, points_m[rows, 2], band, len(full))


def _boxes(
    lines: list[FaceLines], prior: StructurePrior, kind: StructureKind
) -> Iterator[NDArray[np.float64]]:
    """Distances (2, 4) of boxes that the lines of the two directions allow."""
    low, high = (bound * np.array(prior.radius_m) for bound in kind.radius_window)
    across = [list(_slabs(found.at_ends_m, low, high)) for found in lines]
    tall_m = prior.shaft_z_m[1] - prior.shaft_z_m[0]
    for first, second in product(*across):
        for half_first, half_second in _halves(first, second, low, high):
            u, v = first.faces(half_first), second.faces(half_second)
            middle = np.column_stack([u[:, 0] - u[:, 1], v[:, 0] - v[:, 1]]) / 2.0
            lean = np.hypot(*(middle[1] - middle[0])) / tall_m
            rough = PLACE_RADII * float(np.mean(half_first))
            if (
                np.hypot(*middle[0]) <= kind.position_slack_m + rough
                and lean <= kind.max_lean + rough / tall_m
            ):
                yield np.column_stack([u[:, 0], v[:, 0], u[:, 1], v[:, 1]])


@dataclass(frozen=True, slots=True)
class _Slab:
    """A face at the two ends (2,) that looks along (sign 1) or against its direction, with half the side (2,) if known."""

    face_m: NDArray[np.float64]
    sign: float
    half_m: NDArray[np.float64] | None

    def faces(self, half_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distances (2, 2) at the ends of the face along and of the face against the direction."""
        middle = self.face_m - self.sign * half_m
        return np.column_stack([middle + half_m, half_m - middle])


def _slabs(
    at_ends_m: NDArray[np.float64], low_m: NDArray[np.float64], high_m: NDArray[np.float64]
) -> Iterator[_Slab]:
    for upper in at_ends_m:
        for lower in at_ends_m:
            half = (upper - lower) / 2.0
            if (half >= low_m).all() and (half <= high_m).all():
                yield _Slab(upper, 1.0, half)
        yield _Slab(upper, 1.0, None)
        yield _Slab(upper, -1.0, None)


def _halves(
    first: _Slab, second: _Slab, low_m: NDArray[np.float64], high_m: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Half sides in both directions: those seen, an unseen one as the other, both unseen as many as are tried."""
    if first.half_m is not None or second.half_m is not None:
        a = first.half_m if first.half_m is not None else second.half_m
        b = second.half_m if second.half_m is not None else first.half_m
        if a is not None and b is not None:
            yield a, b
        return
    for share in np.linspace(0.0, 1.0, UNSEEN_SIDES):
        half = low_m + share * (high_m - low_m)
        yield half, half


def _score(
    box: RoughFaces, voters: BandPoints, prior: StructurePrior, tolerance_m: float
) -> tuple[float, float]:
    """Score of a box, and the share of its circumference in evidence.

    The square of the length in evidence by the circumference, less for points inside: of two boxes that show the same
    length the smaller one wins, of two that show the same share the larger one.
    """
    distance = box.at(voters.z_m, prior.shaft_z_m)
    split = split_by_face(voters.xy_m, box.azimuth_rad, distance)
    middle, half = _middle_and_half(distance)
    on = np.abs(split.off) <= tolerance_m
    if not on.any():
        return 0.0, 0.0
    tangent_middle = np.take_along_axis(middle, split.face[:, None], axis=1)[:, 0]
    side = np.take_along_axis(half, split.face[:, None], axis=1)[:, 0]
    place = np.clip(((split.along - tangent_middle) / side + 1.0) / 2.0, 0.0, 1.0 - 1e-9)
    cell = (voters.band * SIDES + split.face) * CELLS + (place * CELLS).astype(np.intp)
    share = len(np.unique(cell[on])) / (voters.n_bands * SIDES * CELLS)
    inside = np.count_nonzero(split.off < -3.0 * tolerance_m)
    purity = max(1.0 - INSIDE_COST * inside / np.count_nonzero(on), 0.0)
    return share**2 * float(half.mean()) * purity, share


def _middle_and_half(
    distance_m: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place of the middle along each face (n, 4), and half of its length (n, 4), metres."""
    next_m, before_m = np.roll(distance_m, -1, axis=1), np.roll(distance_m, 1, axis=1)
    # the next normal clockwise runs along the face, the one before against it
    return (next_m - before_m) / 2.0, np.maximum((next_m + before_m) / 2.0, 1e-3)
