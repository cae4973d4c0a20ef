"""Fit the plane faces of a square tower to all of its points at once: lean, taper of every face, twist.

Every face is a plane of its own azimuth whose distance changes with height by Legendre polynomials. Those are orthogonal
over the height, so the linear one is the straight line that fits best uniformly over it, whatever the density of the
points and however the tower bends (to third order). The faces turn together by the twist.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import mad_sigma
from tasks.surface.face_axis import AxisOfFaces, about, axis_of_faces
from tasks.surface.face_equations import (
    STRAIGHT,
    Cut,
    FaceEquations,
    FaceState,
    gather,
    is_bent,
    solve_faces,
)
from tasks.surface.face_form import face_form

MOST_STEPS: Final = 40

MOST_SCALES: Final = 20
"""Scales, and choices of points, before the last ones are kept."""

STEP_SIGMAS: Final = 0.05
"""Planes that move by less than this part of their own standard deviation have settled."""

START_GATE: Final = 0.05
"""Half width, in half sides, of the first gate around the rough faces: they come from a fit of the same points."""

GATE_SHRINK: Final = 0.6

LAST_GATE_SIGMAS: Final = 5.0
"""Half width of the last gate: just beyond the cut of Tukey's weights."""

SMALLEST_SIGMA: Final = 1e-8
"""Scale of noise-free data as a part of the half side: a zero would reject every point."""

LEAST_ON_A_FACE: Final = 50
"""Points that a face needs to count as seen."""

LEAST_SHARE: Final = 0.02
"""Share of all points that a face needs: what has less are strays."""

LEAST_HEIGHT: Final = 0.2
"""Share of the height over which its points must spread: the slope of a short piece says nothing of the tower."""

CURVED: Final = 4
"""Terms of a face whose axis may bend: mean, slope, and two of bending."""


@dataclass(frozen=True, slots=True, eq=False)
class FacesStart:
    """Faces as they are roughly known.

    Attributes
    ----------
    shaft_z_m : (float, float)
        Heights between which the faces are fitted, metres.
    base_m : (2,) array
        East and north of the rough axis at z = 0, metres.
    lean : (2,) array
        Rough lean vector of the axis.
    azimuth_rad : (m,) array
        Azimuths of the outward normals at z = 0, clockwise from grid north, in their order; m is even.
    twist_rad_per_m : float
        Rough twist, clockwise with height.
    half_m : (2, m) array
        Distances of the faces from the axis at the two heights, metres.
    """

    shaft_z_m: tuple[float, float]
    base_m: NDArray[np.float64]
    lean: NDArray[np.float64]
    azimuth_rad: NDArray[np.float64]
    twist_rad_per_m: float
    half_m: NDArray[np.float64]

    def __post_init__(self) -> None:
        m = len(self.azimuth_rad)
        if m < 4 or m % 2 or self.half_m.shape != (2, m):
            raise ShapeError(
                f"FacesStart needs an even number of at least 4 faces and half_m (2, m); got {m} and {self.half_m.shape}"
            )
        if not self.shaft_z_m[1] > self.shaft_z_m[0]:
            raise ShapeError(f"FacesStart needs the lower height first, got {self.shaft_z_m}")


@dataclass(frozen=True, slots=True)
class FaceFit:
    """One face, about the straight axis.

    ``azimuth_rad`` is that of its outward normal at the middle height, ``half_m`` its distance from the axis there and
    ``taper`` the change of that with height; ``n_points`` were used, ``rms_m`` is their root mean square distance from
    it. What is not known of a face that was not seen is None.
    """

    azimuth_rad: float
    half_m: float | None
    taper: float | None
    n_points: int
    rms_m: float | None


@dataclass(frozen=True, slots=True, eq=False)
class FacesFit:
    """The plane faces of a tower.

    Attributes
    ----------
    lean : (2,) array
        Lean vector (d_east/d_up, d_north/d_up) of the straight line that fits the axis best, uniformly over the height.
    lean_covariance : (2, 2) array
        Its covariance from the points alone, which are taken as independent, and from ``assumption``.
    form_covariance : (2, 2) array
        What the form of the faces adds to it: pieces of them that are off their plane.
    base_m : (2,) array
        East and north of that line at z = 0, site frame, metres.
    middle_m : (3,) array
        Its point at the middle height.
    faces : tuple of FaceFit
        In the order of the start.
    twist_rad_per_m, twist_sigma_rad_per_m : float
        Turn of all faces with height, clockwise positive, and its standard deviation.
    bending_m : float or None
        Largest distance of the fitted axis from the straight line within the height, metres; None where no bending was
        fitted.
    noise_m : float
        Robust standard deviation of the points about their faces, metres.
    n_points, n_used, iterations : int
        Points given, points with a weight above zero, and steps of the fit.
    assumption : str or None
        What was assumed beyond the points; None where four faces were seen.
    """

    lean: NDArray[np.float64]
    lean_covariance: NDArray[np.float64]
    form_covariance: NDArray[np.float64]
    base_m: NDArray[np.float64]
    middle_m: NDArray[np.float64]
    faces: tuple[FaceFit, ...]
    twist_rad_per_m: float
    twist_sigma_rad_per_m: float
    bending_m: float | None
    noise_m: float
    n_points: int
    n_used: int
    iterations: int
    assumption: str | None


def fit_faces(points_m: NDArray[np.float64], start: FacesStart) -> FacesFit | FitFailure:
    """Fit a plane to every face that has points, by Tukey's weights, and the axis between opposite faces.

    The axis is the mean of the mid-planes of opposite faces. A face pulls it along its own normal only. Three faces fix
    it if the tapers of both directions are alike, which is then assumed and stated; two adjacent ones do not, because
    their lean and their taper cannot be told apart. Bending is fitted if it is significant; where it is not, straight
    faces are, which a half hidden face needs.

    Parameters
    ----------
    points_m : (n, 3) array
        Points of the isolated shaft, site frame, metres.
    start : FacesStart
        Rough faces, good to a few per cent of half a side.

    Raises
    ------
    ShapeError
        If the points are not (n, 3).

    References
    ----------
    Huber 1981, Robust Statistics, section 7.6 (covariance).
    """
    if points_m.ndim != 2 or points_m.shape[1] != 3:
        raise ShapeError(f"fit_faces needs points (n, 3), got {points_m.shape}")
    low, high = start.shaft_z_m
    inside = points_m[(points_m[:, 2] >= low) & (points_m[:, 2] <= high)]
    curved = _settle_about_axis(inside, _first_state(start, CURVED))
    if not isinstance(curved, FitFailure) and is_bent(curved.state, curved.equations):
        return _fit_of(inside, curved)
    straight = _settle_about_axis(inside, _first_state(start, STRAIGHT))
    return straight if isinstance(straight, FitFailure) else _fit_of(inside, straight)


@dataclass(frozen=True, slots=True, eq=False)
class _Settled:
    state: FaceState
    equations: FaceEquations
    cut: Cut
    iterations: int


def _first_state(start: FacesStart, n_terms: int) -> FaceState:
    low, high = start.shaft_z_m
    middle = (low + high) / 2.0
    distance = np.zeros((len(start.azimuth_rad), n_terms))
    distance[:, 0] = start.half_m.mean(axis=0)
    distance[:, 1] = (start.half_m[1] - start.half_m[0]) / 2.0
    return FaceState(
        z_mid_m=middle,
        half_height_m=(high - low) / 2.0,
        middle_m=start.base_m + middle * start.lean,
        lean=start.lean,
        azimuth_rad=start.azimuth_rad + middle * start.twist_rad_per_m,
        twist_rad_per_m=start.twist_rad_per_m,
        distance_m=distance,
    )


def _settle_about_axis(points_m: NDArray[np.float64], state: FaceState) -> _Settled | FitFailure:
    """Settle, go to the axis that was found, and settle again: of a tower that twists only distances from it are simple."""
    first = _settle(points_m, state)
    if isinstance(first, FitFailure):
        return first
    axis = axis_of_faces(first.state, first.equations)
    return axis if isinstance(axis, FitFailure) else _settle(points_m, about(first.state, axis))


def _settle(points_m: NDArray[np.float64], state: FaceState) -> _Settled | FitFailure:
    """Turn scale and faces by turns until the faces stay."""
    size = float(state.distance_m[:, 0].mean())
    gate = START_GATE * size
    cut = _cut(points_m, state, gate, SMALLEST_SIGMA * size)
    for iteration in range(1, MOST_STEPS + 1):
        # a median that swings between two points, and a point that is now in a corner, now out, would go on for ever
        if 1 < iteration <= MOST_SCALES:
            cut = _cut(points_m, state, gate, SMALLEST_SIGMA * size)
        if isinstance(cut, FitFailure):
            return cut
        equations = gather(points_m, state, cut)
        step = solve_faces(equations)
        if isinstance(step, FitFailure):
            return step
        state = state.moved(step)
        last_gate = LAST_GATE_SIGMAS * cut.sigma_m
        if gate <= 1.01 * last_gate and step.largest(cut.sigma_m) <= STEP_SIGMAS:
            return _Settled(state, equations, cut, iteration)
        gate = max(GATE_SHRINK * gate, last_gate)
    return FitFailure(f"the planes of the faces did not settle in {MOST_STEPS} steps")


def _cut(
    points_m: NDArray[np.float64], state: FaceState, gate_m: float, least_sigma_m: float
) -> Cut | FitFailure:
    """Choose the points by where the faces are now."""
    residuals, seen = _look(points_m, state, gate_m)
    if not (seen & np.roll(seen, 1)).any():
        return FitFailure(
            f"needs {LEAST_ON_A_FACE} points over a fifth of the height on two faces that meet, "
            f"got them on {np.count_nonzero(seen)} of {len(seen)} faces"
        )
    return Cut(max(mad_sigma(residuals), least_sigma_m), gate_m, seen, state)


def _look(
    points_m: NDArray[np.float64], state: FaceState, gate_m: float
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Residuals (k,) of the points within the gate and off the corners, and which faces (m,) have points."""
    m = len(state.azimuth_rad)
    residuals, counts = [], np.zeros(m, dtype=np.int64)
    lowest, highest = np.full(m, np.inf), np.full(m, -np.inf)
    for chunk in state.chunks(points_m):
        split = state.split(chunk)
        near = (np.abs(split.off) <= gate_m) & (split.margin >= gate_m)
        residuals.append(split.off[near])
        counts += np.bincount(split.face[near], minlength=m)
        np.minimum.at(lowest, split.face[near], chunk[near, 2])
        np.maximum.at(highest, split.face[near], chunk[near, 2])
    tall = highest - lowest >= LEAST_HEIGHT * 2.0 * state.half_height_m
    seen = (counts >= LEAST_ON_A_FACE) & (counts >= LEAST_SHARE * counts.sum()) & tall
    return np.concatenate([np.empty(0), *residuals]), seen


def _fit_of(points_m: NDArray[np.float64], settled: _Settled) -> FacesFit | FitFailure:
    axis = axis_of_faces(settled.state, settled.equations)
    if isinstance(axis, FitFailure):
        return axis
    state, equations = settled.state, settled.equations
    twist_sigma = float(np.sqrt(equations.covariance()[-1, -1]))
    return FacesFit(
        lean=axis.lean,
        lean_covariance=axis.lean_covariance,
        form_covariance=face_form(points_m, state, settled.cut, equations, axis.lean_of),
        base_m=axis.middle_m - state.z_mid_m * axis.lean,
        middle_m=np.append(axis.middle_m, state.z_mid_m),
        faces=tuple(_face(i, axis, state, equations) for i in range(len(state.azimuth_rad))),
        twist_rad_per_m=state.twist_rad_per_m,
        twist_sigma_rad_per_m=twist_sigma,
        bending_m=axis.bending_m,
        noise_m=settled.cut.sigma_m,
        n_points=len(points_m),
        n_used=int(equations.n_used.sum()),
        iterations=settled.iterations,
        assumption=axis.assumption,
    )


def _face(index: int, axis: AxisOfFaces, state: FaceState, equations: FaceEquations) -> FaceFit:
    azimuth = float(state.azimuth_rad[index] % (2.0 * np.pi))
    n = int(equations.n_used[index])
    if not equations.seen[index]:
        return FaceFit(azimuth, None, None, n, None)
    rms = float(np.sqrt(equations.squares_m2[index] / n))
    return FaceFit(azimuth, float(axis.half_m[index]), float(axis.taper[index]), n, rms)
