"""Normal equations of plane faces: a polynomial in height and an azimuth for each, one twist for all."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray

from tasks.geometry.faces import FaceSplit, split_by_face
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import TUKEY_1D, tukey_weights

CHUNK: Final = 65_536
"""Points that are worked on at once: what is made of them on the way stays in the processor's cache."""

BENT: Final = 0.99
"""Probability beyond which the bending terms of the faces together are no chance."""

STRAIGHT: Final = 2
"""Terms of a straight face: mean and slope."""

ILL: Final = 1e12
"""Condition of the scaled normal matrix from which on the points do not fix the faces."""


@dataclass(frozen=True, slots=True, eq=False)
class FaceStep:
    """Changes: distances (m, t), azimuths (m,), twist.

    ``solution`` (q,) are those of faces with points, one after the other, ``cofactor`` (q,) their variances for points of
    unit variance.
    """

    distance_m: NDArray[np.float64]
    azimuth_rad: NDArray[np.float64]
    twist_rad_per_m: float
    solution: NDArray[np.float64]
    cofactor: NDArray[np.float64]

    def largest(self, sigma_m: float) -> float:
        """Largest change as a part of the standard deviation that noise of ``sigma_m`` leaves in it."""
        return float(np.max(np.abs(self.solution) / (sigma_m * np.sqrt(self.cofactor))))


@dataclass(frozen=True, slots=True, eq=False)
class FaceState:
    """Faces about a fixed straight axis through ``middle_m`` (2,) at ``z_mid_m`` with the lean ``lean`` (2,).

    ``distance_m`` (m, t) are the coefficients of Legendre polynomials of the height, which runs from -1 to 1 over twice
    ``half_height_m``; ``azimuth_rad`` (m,) hold at the middle height.
    """

    z_mid_m: float
    half_height_m: float
    middle_m: NDArray[np.float64]
    lean: NDArray[np.float64]
    azimuth_rad: NDArray[np.float64]
    twist_rad_per_m: float
    distance_m: NDArray[np.float64]

    def chunks(self, points_m: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
        """Points (n, 3) in pieces."""
        for start in range(0, len(points_m), CHUNK):
            yield points_m[start : start + CHUNK]

    def terms(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Polynomials (n, t) at heights (n,)."""
        return np.asarray(legvander((z_m - self.z_mid_m) / self.half_height_m, self.distance_m.shape[1] - 1))

    def split(self, points_m: NDArray[np.float64]) -> FaceSplit:
        """Points (n, 3) by face."""
        rise = points_m[:, 2] - self.z_mid_m
        xy = points_m[:, :2] - self.middle_m - rise[:, None] * self.lean
        distance = self.terms(points_m[:, 2]) @ self.distance_m.T
        return split_by_face(xy, self.azimuth_rad, distance, self.twist_rad_per_m * rise)

    def moved(self, step: FaceStep) -> "FaceState":
        """Faces after a step."""
        return replace(
            self,
            azimuth_rad=self.azimuth_rad + step.azimuth_rad,
            twist_rad_per_m=self.twist_rad_per_m + step.twist_rad_per_m,
            distance_m=self.distance_m + step.distance_m,
        )


@dataclass(frozen=True, slots=True, eq=False)
class FaceEquations:
    """Normal equations, face by face: t distances and the azimuth; the twist comes last.

    Attributes
    ----------
    seen : (m,) bool array
        Faces that have points; the others have no equations.
    n_terms : int
        Terms of a face's distance.
    normal, right
        Weighted normal matrix (p, p) and right side (p,).
    plain : (p, p) array
        Normal matrix of the used points without weights.
    n_used, squares_m2 : (m,) arrays
        Points with a weight above zero by face, and the sum of their squared residuals.
    influence_m2, slope : float
        Sums over the used points of the squared influence and of its slope.
    """

    seen: NDArray[np.bool_]
    n_terms: int
    normal: NDArray[np.float64]
    right: NDArray[np.float64]
    plain: NDArray[np.float64]
    n_used: NDArray[np.int64]
    squares_m2: NDArray[np.float64]
    influence_m2: float
    slope: float

    @property
    def free(self) -> NDArray[np.intp]:
        """Unknowns (q,) that have equations."""
        return np.flatnonzero(np.append(np.repeat(self.seen, self.n_terms + 1), True))

    def covariance(self) -> NDArray[np.float64]:
        """Covariance (p, p): A / B^2 of Huber times the inverse of the plain normal matrix; zero for faces unseen."""
        free, n = self.free, int(self.n_used.sum())
        variance = self.influence_m2 / (n - len(free)) / (self.slope / n) ** 2
        covariance = np.zeros_like(self.plain)
        covariance[np.ix_(free, free)] = variance * np.linalg.inv(self.plain[np.ix_(free, free)])
        return covariance


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """Which points count: scale of their weights, half width of the gate, faces (m,), and where the corners are."""

    sigma_m: float
    gate_m: float
    seen: NDArray[np.bool_]
    corners: FaceState


def gather(points_m: NDArray[np.float64], state: FaceState, cut: Cut) -> FaceEquations:
    """Sum the equations of the points (n, 3) within the gate and off the corners, in pieces."""
    sigma_m, seen = cut.sigma_m, cut.seen
    m, t = state.distance_m.shape
    size = m * (t + 1) + 1
    normal, plain, right = np.zeros((size, size)), np.zeros((size, size)), np.zeros(size)
    n_used, squares = np.zeros(m, dtype=np.int64), np.zeros(m)
    influence = slope = 0.0
    for chunk in state.chunks(points_m):
        split = state.split(chunk)
        margin = split.margin if cut.corners is state else cut.corners.split(chunk).margin
        weights = tukey_weights(split.off, sigma_m)
        weights[(np.abs(split.off) > cut.gate_m) | (margin < cut.gate_m) | ~seen[split.face]] = 0.0
        terms, rise = state.terms(chunk[:, 2]), chunk[:, 2] - state.z_mid_m
        for face in np.flatnonzero(seen):
            rows = np.flatnonzero((split.face == face) & (weights > 0.0))
            off, weight, along = split.off[rows], weights[rows], split.along[rows]
            design = np.column_stack([terms[rows], -along, -along * rise[rows]])
            places = np.append(face * (t + 1) + np.arange(t + 1), size - 1)
            block = np.ix_(places, places)
            normal[block] += (design * weight[:, None]).T @ design
            plain[block] += design.T @ design
            right[places] += design.T @ (weight * off)
            n_used[face] += len(rows)
            squares[face] += float(off @ off)
            ratio = (off / (TUKEY_1D * sigma_m)) ** 2
            influence += float(np.sum((weight * off) ** 2))
            slope += float(np.sum((1.0 - ratio) * (1.0 - 5.0 * ratio)))
    return FaceEquations(seen, t, normal, right, plain, n_used, squares, influence, slope)


def solve_faces(equations: FaceEquations) -> FaceStep | FitFailure:
    """Solve for the step; zero for faces without points."""
    free, t = equations.free, equations.n_terms
    normal = equations.normal[np.ix_(free, free)]
    scale = np.sqrt(np.diag(normal))
    if not (scale > 0.0).all() or np.linalg.cond(normal / np.outer(scale, scale)) > ILL:
        return FitFailure("needs points that fix every face, got too few heights or too narrow faces")
    if equations.slope <= 0.0:
        return FitFailure("needs residuals that gather about plane faces, got ones that spread evenly")
    step = np.zeros(len(equations.right))
    inverse = np.linalg.inv(normal)
    step[free] = inverse @ equations.right[free]
    by_face = step[:-1].reshape(len(equations.seen), t + 1)
    return FaceStep(by_face[:, :t], by_face[:, t], float(step[-1]), step[free], np.diag(inverse))


def is_bent(state: FaceState, equations: FaceEquations) -> bool:
    """Whether the terms beyond the straight ones, of all faces together, are more than chance."""
    t = equations.n_terms
    places = np.array(
        [face * (t + 1) + term for face in np.flatnonzero(equations.seen) for term in range(STRAIGHT, t)],
        dtype=np.intp,
    )
    if not len(places):
        return False
    bent = state.distance_m[equations.seen, STRAIGHT:].ravel()
    spread = equations.covariance()[np.ix_(places, places)]
    from scipy.special import chdtri  # noqa: PLC0415 (slow to import, and every command reads settings)

    return bool(bent @ np.linalg.solve(spread, bent) > chdtri(len(places), 1.0 - BENT))
