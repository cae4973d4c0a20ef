"""A straight line for every face of a section: offsets of their own, one rotation for all."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.outline import Outline
from tasks.geometry.faces import FaceSplit, split_by_face
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import TUKEY_1D, mad_sigma, tukey_weights

FIRST_GATE: Final = 0.1
"""Half width, in half sides, of the first gate around the rough faces."""

CORNER: Final = 0.5
"""Points nearer to a corner than this part of the gate belong to no face: noise decides to which."""

GATE_SHRINK: Final = 0.6
"""The gate narrows by this factor a step until only noise fits through."""

LAST_GATE_SIGMAS: Final = 5.0
"""Half width of the last gate: just beyond the cut of Tukey's weights."""

STEP: Final = 1e-6
"""Lines that move by less than this part of a half side have settled."""

MOST_STEPS: Final = 60

MOST_SCALES: Final = 25
"""Scales, and choices of points, before the last ones are kept."""

MOST_NOISE: Final = 0.05
"""Largest believable noise as a part of the half side: a circle is off the best square by 0.07."""

LEAST_ON_A_FACE: Final = 8
"""A line through fewer points may be one through strays."""

LEAST_SPAN: Final = 0.1
"""Share of a side over which its points must spread: a pipe is no face."""

SMALLEST_SIGMA: Final = 1e-7
"""Scale of noise-free data as a part of the half side: a zero would reject every point but one."""


@dataclass(frozen=True, slots=True, eq=False)
class FacePoints:
    """Points (n, 2) about the rough centre, lean taken out, and how far they are above the section's height (n,)."""

    xy_m: NDArray[np.float64]
    rise_m: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FaceLinesFit:
    """Lines of the faces that have points.

    Attributes
    ----------
    outline : Outline
        The faces where they were found, about their own centre as far as that is known.
    seen : (m,) bool array
        Which faces have points.
    split : FaceSplit
        The points by face.
    used : (n,) bool array
        Points with a weight above zero.
    covariance_m2 : (m, m) array
        Covariance of the distances of the seen faces; zero rows for the others.
    sigma_m : float
        Robust standard deviation of the points about their lines, metres.
    """

    outline: Outline
    seen: NDArray[np.bool_]
    split: FaceSplit
    used: NDArray[np.bool_]
    covariance_m2: NDArray[np.float64]
    sigma_m: float


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """Faces (m,) about the rough centre: azimuths, distances, change of these with height."""

    azimuth_rad: NDArray[np.float64]
    distance_m: NDArray[np.float64]
    taper: NDArray[np.float64]

    def split(self, points: FacePoints) -> FaceSplit:
        distance = self.distance_m + points.rise_m[:, None] * self.taper
        return split_by_face(points.xy_m, self.azimuth_rad, distance)


def fit_face_lines(points: FacePoints, start: Outline) -> FaceLinesFit | FitFailure:
    """Fit lines to the faces by Tukey's weights; points near a corner count for none.

    The angles between the faces are those of ``start``; one rotation is common to all of them.
    """
    state = _State(start.azimuth_rad, start.half_m, start.taper)
    size = float(start.half_m.mean())
    gate, sigma, near = FIRST_GATE * size, 0.0, np.zeros(len(points.rise_m), dtype=np.bool_)
    for count in range(MOST_STEPS):
        split = state.split(points)
        # a point that is now in, now out, and a median between two points would go on for ever
        if count < MOST_SCALES:
            near = (np.abs(split.off) <= gate) & (split.margin >= CORNER * gate)
        seen = _seen(split, near, state.distance_m)
        if np.count_nonzero(seen) < 2:
            return FitFailure(
                f"needs points on two faces that meet, got them on {np.count_nonzero(seen)} of {len(seen)}"
            )
        sigma = max(mad_sigma(split.off[near]), SMALLEST_SIGMA * size) if count < MOST_SCALES else sigma
        weights = np.where(near & seen[split.face], tukey_weights(split.off, sigma), 0.0)
        step = _step(split, weights, seen)
        if gate <= 1.01 * LAST_GATE_SIGMAS * sigma and float(np.abs(step).max()) <= STEP * size:
            return _finished(state, start, split, weights, sigma)
        state = _moved(state, step, size)
        gate = max(GATE_SHRINK * gate, LAST_GATE_SIGMAS * sigma)
    return FitFailure(f"the lines of the faces did not settle in {MOST_STEPS} steps")


def _seen(split: FaceSplit, near: NDArray[np.bool_], distance_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    m = len(distance_m)
    seen = np.zeros(m, dtype=np.bool_)
    sides = np.roll(distance_m, 1) + np.roll(distance_m, -1)
    for face in range(m):
        along = split.along[near & (split.face == face)]
        seen[face] = len(along) >= LEAST_ON_A_FACE and np.ptp(along) >= LEAST_SPAN * sides[face]
    return seen


def _design(split: FaceSplit, rows: NDArray[np.intp], n_faces: int) -> NDArray[np.float64]:
    """Derivatives (k, m + 1) of minus the residuals of points by the distances and the rotation."""
    design = np.zeros((len(rows), n_faces + 1))
    design[np.arange(len(rows)), split.face[rows]] = 1.0
    design[:, -1] = -split.along[rows]
    return design


def _step(split: FaceSplit, weights: NDArray[np.float64], seen: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Step (m + 1,) of the distances and, times a radian, the rotation; zero for faces without points."""
    rows = np.flatnonzero(weights > 0.0)
    design = _design(split, rows, len(seen))
    weighted = design.T * weights[rows]
    free = np.append(seen, True)
    step = np.zeros(len(free))
    step[free] = np.linalg.lstsq(
        (weighted @ design)[np.ix_(free, free)], (weighted @ split.off[rows])[free], rcond=None
    )[0]
    return step


def _moved(state: _State, step: NDArray[np.float64], size: float) -> _State:
    # a rotation of more than a tenth in one step leaves the linear range
    turn = float(np.clip(step[-1], -0.1, 0.1))
    distance = np.maximum(state.distance_m + step[:-1], 1e-3 * size)
    return replace(state, azimuth_rad=state.azimuth_rad + turn, distance_m=distance)


def _finished(
    state: _State,
    start: Outline,
    split: FaceSplit,
    weights: NDArray[np.float64],
    sigma_m: float,
) -> FaceLinesFit | FitFailure:
    """State the lines with the covariance of their distances, as A / B^2 of Huber with the price of robustness in it."""
    size = float(state.distance_m.mean())
    if sigma_m > MOST_NOISE * size:
        return FitFailure(
            f"needs straight faces, got points {sigma_m:.3g} m off them at half a side of {size:.3g} m"
        )
    used = weights > 0.0
    candidates = split.margin >= CORNER * LAST_GATE_SIGMAS * sigma_m
    n, n_candidates = int(used.sum()), int(np.count_nonzero(candidates | used))
    if 2 * n < n_candidates:
        return FitFailure(f"needs most points on straight faces, got {n} of {n_candidates}")
    seen = np.bincount(split.face[used], minlength=len(state.azimuth_rad)) > 0
    free = np.append(seen, True)
    if n <= 2 * np.count_nonzero(free):
        return FitFailure(f"needs more points on its faces, got {n}")
    ratio = (split.off[used] / (TUKEY_1D * sigma_m)) ** 2
    influence = float(np.sum((weights[used] * split.off[used]) ** 2)) / (n - np.count_nonzero(free))
    slope = float(np.mean((1.0 - ratio) * (1.0 - 5.0 * ratio)))
    if slope <= 0.0:
        return FitFailure("needs residuals that gather about straight faces, got ones that spread evenly")
    design = _design(split, np.flatnonzero(used), len(seen))[:, free]
    inverse = np.linalg.inv(design.T @ design) * influence / slope**2
    covariance = np.zeros((len(free), len(free)))
    covariance[np.ix_(free, free)] = inverse
    outline = replace(start, azimuth_rad=state.azimuth_rad, half_m=state.distance_m)
    return FaceLinesFit(outline, seen, split, used, covariance[:-1, :-1], sigma_m)
