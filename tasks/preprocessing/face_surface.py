"""The surface of a shaft with plane faces: each face straight across, piecewise linear in height, all turning together.

Stiffness (small second differences of the faces' distances) carries a face through heights at which it is hidden. A face
that is never seen is put where the side of the other direction, or the rough box, has it; that its distance was not
measured is kept.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.faces import FaceSplit, centre_matrix, normals_of, opposite_pairs, split_by_face
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import MAD_TO_SIGMA, tukey_weights
from tasks.preprocessing.model import ShaftFace, ShaftModel
from tasks.preprocessing.surface import (
    BEND_SD_RADII,
    CHUNK,
    GATE_SHRINK,
    ITERATIONS_MAX,
    NOISE_LIMIT_M,
    NOISE_LIMIT_RADII,
    POINTS_NEEDED,
    POINTS_PER_INDEPENDENT_ONE,
    SIGMA_FLOOR_M,
    STEP_DONE_SIGMAS,
    SurfaceDistance,
)

SHARE_OF_A_FACE: Final = 0.02
"""A face with less than this share of the points is not seen: what is there are strays."""

TURN_SD_RAD_PER_M: Final = 0.01
"""Prior sd of the twist: half a degree a metre is more than any tower has."""


@dataclass(frozen=True, slots=True)
class FaceSurface:
    """Faces of a shaft.

    ``knots_z_m`` (k,) evenly spaced; ``origin_m`` (2,) a fixed vertical line from which ``distance_m`` (k, m) is counted
    along the normals ``azimuth_rad`` (m,) at the middle height; all normals turn by ``twist_rad_per_m``. ``seen`` (m,)
    says which faces have points, ``variance_m2`` (m, k, k) how well their distances are known; ``sigma_m`` is the noise.
    """

    knots_z_m: NDArray[np.float64]
    origin_m: NDArray[np.float64]
    azimuth_rad: NDArray[np.float64]
    distance_m: NDArray[np.float64]
    twist_rad_per_m: float
    seen: NDArray[np.bool_]
    variance_m2: NDArray[np.float64]
    sigma_m: float

    @property
    def z_mid_m(self) -> float:
        """Height at which the azimuths hold, metres."""
        return float(self.knots_z_m[[0, -1]].mean())

    @property
    def half_m(self) -> NDArray[np.float64]:
        """Distances (k, m) of the faces from the axis, metres."""
        # turning all faces about the origin by the twist turns the centre with them and leaves the distances
        return np.asarray(self.distance_m - self._centres() @ normals_of(self.azimuth_rad).T)

    @property
    def axis_m(self) -> NDArray[np.float64]:
        """East and north (k, 2) of the axis at the knots, metres."""
        turn = self.twist_rad_per_m * (self.knots_z_m - self.z_mid_m)
        c, s = np.cos(turn), np.sin(turn)
        x, y = self._centres().T
        return np.asarray(self.origin_m + np.column_stack([c * x + s * y, c * y - s * x]))

    def _centres(self) -> NDArray[np.float64]:
        """Centres (k, 2) about the origin, the twist taken back."""
        return np.asarray(self.distance_m @ centre_matrix(self.azimuth_rad).T)


@dataclass(frozen=True, slots=True)
class _Look:
    """Points as the faces see them: (n,) interval and share of the upper knot, height about the middle, and the split."""

    interval: NDArray[np.int64]
    upper: NDArray[np.float64]
    rise_m: NDArray[np.float64]
    split: FaceSplit


@dataclass(frozen=True, slots=True)
class _Step:
    """Change of the distances (k, m), the azimuths (m,) and the twist, with variances (m, k, k) of the distances."""

    distance_m: NDArray[np.float64]
    azimuth_rad: NDArray[np.float64]
    twist_rad_per_m: float
    variance_m2: NDArray[np.float64]


def distance_from_faces(surface: FaceSurface, points_m: NDArray[np.float64]) -> SurfaceDistance:
    """Measure points (n, 3) from the nearest face; in chunks, to keep the memory small."""
    distance = SurfaceDistance(np.empty(len(points_m)), np.empty(len(points_m)))
    half = surface.half_m.mean(axis=1)
    for start in range(0, len(points_m), CHUNK):
        rows = slice(start, start + CHUNK)
        distance.off_m[rows] = _look(surface, points_m[rows]).split.off
        distance.radius_m[rows] = np.interp(points_m[rows, 2], surface.knots_z_m, half)
    return distance


def unroll_faces(surface: FaceSurface, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length (n,) along the unrolled faces at which points (n, 3) lie, metres; in chunks."""
    around_m = np.empty(len(points_m))
    # a side of constant length: the unrolled faces stand side by side
    side_m = 2.0 * surface.half_m.mean(axis=1).max()
    for start in range(0, len(points_m), CHUNK):
        rows = slice(start, start + CHUNK)
        split = _look(surface, points_m[rows]).split
        around_m[rows] = side_m * split.face + split.along
    return around_m


def fit_faces_surface(
    start: FaceSurface, points_m: NDArray[np.float64], gate_m: float
) -> FaceSurface | FitFailure:
    """Fit the faces to points (n, 3) by Tukey's weights, starting within ``gate_m`` of ``start``.

    Points near a corner count for no face; heights are taken as exact.
    """
    surface = start
    for _ in range(ITERATIONS_MAX):
        look = _look(surface, points_m)
        near = (np.abs(look.split.off) <= gate_m) & (look.split.margin >= gate_m)
        seen = _seen(look, near, len(surface.seen))
        if np.count_nonzero(near) < POINTS_NEEDED or not (seen & np.roll(seen, 1)).any():
            return FitFailure(
                f"needed {POINTS_NEEDED} points within {gate_m:.3f} m of two faces that meet, "
                f"got {np.count_nonzero(near)} of {len(points_m)} on {np.count_nonzero(seen)} faces"
            )
        sigma_m = max(MAD_TO_SIGMA * float(np.median(np.abs(look.split.off[near]))), SIGMA_FLOOR_M)
        before = surface
        surface = _moved(surface, _step(surface, look, near, seen, sigma_m), seen, sigma_m)
        if not (np.isfinite(surface.distance_m).all() and surface.half_m.min() > 0.0):
            return FitFailure("the fit of the faces ran away: needed positive sides at all heights")
        settled = gate_m <= 5.0 * sigma_m
        gate_m = max(GATE_SHRINK * gate_m, 5.0 * sigma_m)
        moved_m = np.abs(surface.distance_m - before.distance_m).max()
        if settled and moved_m <= STEP_DONE_SIGMAS * sigma_m:
            break
    else:
        return FitFailure(
            f"the fit of the faces needed to settle within {ITERATIONS_MAX} iterations, it did not"
        )
    limit_m = NOISE_LIMIT_M + NOISE_LIMIT_RADII * float(surface.half_m.mean())
    if surface.sigma_m > limit_m:
        return FitFailure(f"needed plane faces with noise below {limit_m:.3f} m, got {surface.sigma_m:.3f} m")
    return surface


def model_of_faces(surface: FaceSurface) -> ShaftModel:
    """Split the axis between the faces into the straight line, uniform over the height, and the bending about it."""
    z_m, axis_m, half_m = surface.knots_z_m, surface.axis_m, surface.half_m
    line = np.polyfit(z_m, axis_m, 1)
    bend_m = axis_m - z_m[:, None] * line[0] - line[1]
    variance = np.einsum("mkk->mk", surface.variance_m2)
    opposite = np.roll(np.arange(len(surface.seen)), len(surface.seen) // 2)
    at_zero = surface.azimuth_rad - surface.twist_rad_per_m * surface.z_mid_m
    faces = tuple(
        ShaftFace(
            azimuth_rad=float(at_zero[i] % (2.0 * np.pi)),
            distance_m=tuple(half_m[:, i].tolist()),
            sigma_m=tuple((np.sqrt(variance[i] + variance[j]) / 2.0).tolist())
            if surface.seen[i] and surface.seen[j]
            else None,
        )
        for i, j in enumerate(opposite)
    )
    return ShaftModel(
        base_east_m=float(line[1, 0]),
        base_north_m=float(line[1, 1]),
        lean_east=float(line[0, 0]),
        lean_north=float(line[0, 1]),
        radius_z_m=tuple(z_m.tolist()),
        radius_m=tuple(half_m.mean(axis=1).tolist()),
        bend_east_m=tuple(bend_m[:, 0].tolist()),
        bend_north_m=tuple(bend_m[:, 1].tolist()),
        noise_sigma_m=surface.sigma_m,
        faces=faces,
        twist_rad_per_m=surface.twist_rad_per_m,
    )


def _look(surface: FaceSurface, points_m: NDArray[np.float64]) -> _Look:
    knots, distance = surface.knots_z_m, surface.distance_m
    place = (points_m[:, 2] - knots[0]) / (knots[1] - knots[0])
    interval = np.clip(place.astype(np.int64), 0, len(knots) - 2)
    upper = np.clip(place - interval, 0.0, 1.0)
    at_point = distance[interval] + upper[:, None] * np.diff(distance, axis=0)[interval]
    rise = points_m[:, 2] - surface.z_mid_m
    split = split_by_face(
        points_m[:, :2] - surface.origin_m, surface.azimuth_rad, at_point, surface.twist_rad_per_m * rise
    )
    return _Look(interval, upper, rise, split)


def _seen(look: _Look, near: NDArray[np.bool_], n_faces: int) -> NDArray[np.bool_]:
    counts = np.bincount(look.split.face[near], minlength=n_faces)
    return np.asarray((counts >= POINTS_NEEDED / 4) & (counts >= SHARE_OF_A_FACE * counts.sum()))


def _step(
    surface: FaceSurface, look: _Look, near: NDArray[np.bool_], seen: NDArray[np.bool_], sigma_m: float
) -> _Step:
    """Gauss-Newton step of the distances of the faces that are seen, their azimuths and the twist."""
    k, m = surface.distance_m.shape
    normal, right = _stiffness(surface, sigma_m)
    weights = np.where(near, tukey_weights(look.split.off, sigma_m), 0.0)
    twist = m * (k + 1)
    for face in np.flatnonzero(seen):
        rows = np.flatnonzero((look.split.face == face) & (weights > 0.0))
        columns = np.concatenate([face * k + np.arange(k), [m * k + face, twist]])
        design = np.zeros((len(rows), k + 2))
        interval, upper = look.interval[rows], look.upper[rows]
        design[np.arange(len(rows)), interval] = 1.0 - upper
        design[np.arange(len(rows)), interval + 1] += upper
        design[:, k] = -look.split.along[rows]
        design[:, k + 1] = -look.split.along[rows] * look.rise_m[rows]
        weighted = design * weights[rows, None]
        normal[np.ix_(columns, columns)] += weighted.T @ design
        right[columns] += weighted.T @ look.split.off[rows]
    for face in np.flatnonzero(~seen):
        normal[m * k + face, m * k + face] += 1.0
    solution = np.asarray(np.linalg.solve(normal, right), dtype=np.float64)
    # neighbouring points err together: what they say is worth less than their number
    spread = POINTS_PER_INDEPENDENT_ONE * sigma_m**2 * np.linalg.inv(normal)
    variance = np.stack([spread[i * k : (i + 1) * k, i * k : (i + 1) * k] for i in range(m)])
    return _Step(solution[: m * k].reshape(m, k).T, solution[m * k : twist], float(solution[twist]), variance)


def _stiffness(surface: FaceSurface, sigma_m: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normal matrix and right side of the prior, in units in which a point weighs 1."""
    k, m = surface.distance_m.shape
    scale = POINTS_PER_INDEPENDENT_ONE * sigma_m**2
    bend = np.diff(np.eye(k), 2, axis=0)
    smooth = scale * bend.T @ bend / (BEND_SD_RADII * float(surface.half_m.mean())) ** 2
    # a trace of damping: a face that is not seen must leave the matrix regular
    damping = 1e-9 * np.trace(smooth) * np.eye(k)
    size = m * (k + 1) + 1
    normal, right = np.zeros((size, size)), np.zeros(size)
    for face in range(m):
        block = slice(face * k, (face + 1) * k)
        normal[block, block] = smooth + damping
        right[block] = -smooth @ surface.distance_m[:, face]
    normal[-1, -1] = scale / TURN_SD_RAD_PER_M**2
    right[-1] = -normal[-1, -1] * surface.twist_rad_per_m
    return normal, right


def _moved(surface: FaceSurface, step: _Step, seen: NDArray[np.bool_], sigma_m: float) -> FaceSurface:
    """Move the faces that are seen, and put the others where sides of the same length have them."""
    azimuth = np.where(seen, surface.azimuth_rad + step.azimuth_rad, surface.azimuth_rad)
    distance = np.where(seen, surface.distance_m + step.distance_m, surface.distance_m)
    pairs = opposite_pairs(len(seen))
    whole = [(i, j) for i, j in pairs if seen[i] and seen[j]]
    if whole:
        side = np.mean([distance[:, i] + distance[:, j] for i, j in whole], axis=0)
    else:
        side = 2.0 * surface.half_m.mean(axis=1)
    for i, j in np.vstack([pairs, pairs[:, ::-1]]):
        if seen[i] and not seen[j]:
            distance[:, j], azimuth[j] = side - distance[:, i], azimuth[i] + np.pi
    return replace(
        surface,
        azimuth_rad=azimuth,
        distance_m=distance,
        twist_rad_per_m=surface.twist_rad_per_m + step.twist_rad_per_m,
        seen=seen,
        variance_m2=step.variance_m2,
        sigma_m=sigma_m,
    )
