"""The surface of a shaft: an axis that may bend, a radius that may change, a section that may be oval or three-lobed.

All of it is piecewise linear in height. Stiffness (small second differences of axis and radius, small and slowly
changing lobes) carries it through heights that are half hidden, where the position of the centre along the line of
sight, the radius and the ovality cannot be told apart from the points of that height alone (docs/estimators.md).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import MAD_TO_SIGMA, tukey_weights
from tasks.geometry.side_by_side import side_by_side

TERMS: Final = 7
"""Unknowns a knot: east, north, radius, and the cosine and sine of 2 and of 3 times the angle."""

BEND_SD_RADII: Final = 0.01
"""Prior sd of a second difference of axis or radius between knots, in radii."""

LOBE_SD_RADII: Final = 0.02
"""Prior sd of the amplitude of a lobe, in radii."""

LOBE_CHANGE_SD_RADII: Final = 0.003
"""Prior sd of its change from knot to knot, in radii."""

POINTS_PER_INDEPENDENT_ONE: Final = 30.0
"""Neighbouring points err together (registration, roughness): they are worth this many times less. Only the
stiffness of the surface hangs on it."""

SIGMA_FLOOR_M: Final = 1e-4
"""Smallest noise believed: below it a perfect synthetic surface would reject its own rounding."""

ITERATIONS_MAX: Final = 200
"""Most shafts need 15; beside a ledge, where the radius steps, a knot may go slowly from the one wall to the other."""

STEP_DONE_SIGMAS: Final = 0.01
"""Finished when no unknown moves by more than this share of the noise."""

GATE_SHRINK: Final = 0.6
"""The gate of the fit narrows by this factor a step until only noise fits through."""

POINTS_NEEDED: Final = 50

CHUNK: Final = 1 << 18
"""Points placed by one thread at once."""

NOISE_LIMIT_M: Final = 0.03
NOISE_LIMIT_RADII: Final = 0.03
"""Largest believable noise is the sum of the two: scanner and bark, and what is not quite round; a square has more."""


@dataclass(frozen=True, slots=True)
class Surface:
    """A shaft surface: knots (k,) in z, values (k, ``TERMS``) at them in metres, robust noise in metres."""

    knots_z_m: NDArray[np.float64]
    values_m: NDArray[np.float64]
    sigma_m: float


@dataclass(frozen=True, slots=True)
class SurfaceDistance:
    """Horizontal distance (n,) of points from a surface, positive outside, and mean radius (n,) there, metres."""

    off_m: NDArray[np.float64]
    radius_m: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Look:
    """Points as a surface sees them: (n,) interval, share of the upper knot, residual, mean radius; terms (n, 7)."""

    interval: NDArray[np.int64]
    upper: NDArray[np.float64]
    residual_m: NDArray[np.float64]
    radius_m: NDArray[np.float64]
    terms: NDArray[np.float64]


def distance_from(surface: Surface, points_m: NDArray[np.float64]) -> SurfaceDistance:
    """Measure points (n, 3) from the surface; in chunks, side by side."""
    from tasks.preprocessing.kernels import measure_points  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    off_m, radius_m = np.empty(len(points_m)), np.empty(len(points_m))
    low_m, step_m = _even_knots(surface)

    def of_chunk(start: int) -> None:
        rows = slice(start, start + CHUNK)
        measure_points(points_m[rows], low_m, step_m, surface.values_m, off_m[rows], radius_m[rows])

    side_by_side(of_chunk, range(0, len(points_m), CHUNK))
    return SurfaceDistance(off_m, radius_m)


def unroll(surface: Surface, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Arc length (n,) around the axis at which points (n, 3) lie, metres; in chunks, side by side."""
    from tasks.preprocessing.kernels import unroll_points  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    around_m = np.empty(len(points_m))
    low_m, step_m = _even_knots(surface)

    def of_chunk(start: int) -> None:
        rows = slice(start, start + CHUNK)
        unroll_points(points_m[rows], low_m, step_m, surface.values_m, around_m[rows])

    side_by_side(of_chunk, range(0, len(points_m), CHUNK))
    return around_m


def _even_knots(surface: Surface) -> tuple[float, float]:
    """Lowest knot and the step to the next, metres."""
    low_m, next_m = surface.knots_z_m[:2]
    return float(low_m), float(next_m - low_m)


def fit_surface(start: Surface, points_m: NDArray[np.float64], gate_m: float) -> Surface | FitFailure:
    """Fit the surface to points (n, 3) by Tukey's weights, starting within ``gate_m`` of ``start``.

    Gauss-Newton on horizontal distances; heights are taken as exact.
    """
    surface = start
    for _ in range(ITERATIONS_MAX):
        look = _look(surface, points_m)
        near = np.abs(look.residual_m) <= gate_m
        if np.count_nonzero(near) < POINTS_NEEDED:
            return FitFailure(
                f"needed {POINTS_NEEDED} points within {gate_m:.3f} m of the rough surface, "
                f"got {np.count_nonzero(near)} of {len(points_m)}"
            )
        # the median of both sides: a ladder outside must not shift the zero, only widen the scale
        sigma_m = max(MAD_TO_SIGMA * float(np.median(np.abs(look.residual_m[near]))), SIGMA_FLOOR_M)
        step_m = _step(surface, look, sigma_m)
        surface = Surface(surface.knots_z_m, surface.values_m + step_m, sigma_m)
        if not (np.isfinite(surface.values_m).all() and surface.values_m[:, 2].min() > 0.0):
            return FitFailure("the surface fit ran away: needed positive radii at all heights")
        settled = gate_m <= 5.0 * sigma_m
        gate_m = max(GATE_SHRINK * gate_m, 5.0 * sigma_m)
        if settled and np.max(np.abs(step_m)) <= STEP_DONE_SIGMAS * sigma_m:
            break
    else:
        return FitFailure(f"the surface fit needed to settle within {ITERATIONS_MAX} iterations, it did not")
    limit_m = NOISE_LIMIT_M + NOISE_LIMIT_RADII * float(surface.values_m[:, 2].mean())
    if surface.sigma_m > limit_m:
        return FitFailure(
            f"needed a round or oval surface with noise below {limit_m:.3f} m, got {surface.sigma_m:.3f} m"
        )
    return surface


def _look(surface: Surface, points_m: NDArray[np.float64]) -> _Look:
    knots, values = surface.knots_z_m, surface.values_m
    place = (points_m[:, 2] - knots[0]) / (knots[1] - knots[0])
    interval = np.clip(place.astype(np.int64), 0, len(knots) - 2)
    upper = np.clip(place - interval, 0.0, 1.0)
    at_point = values[interval] + upper[:, None] * np.diff(values, axis=0)[interval]
    east, north = points_m[:, 0] - at_point[:, 0], points_m[:, 1] - at_point[:, 1]
    distance = np.maximum(np.hypot(east, north), 1e-9)
    terms = np.empty((len(points_m), TERMS))
    c, s = np.divide(east, distance, out=terms[:, 0]), np.divide(north, distance, out=terms[:, 1])
    terms[:, 2] = 1.0
    c2, s2 = c * c - s * s, 2.0 * c * s
    terms[:, 3], terms[:, 4] = c2, s2
    terms[:, 5], terms[:, 6] = c2 * c - s2 * s, s2 * c + c2 * s
    radius = np.einsum("ij,ij->i", terms[:, 2:], at_point[:, 2:])
    return _Look(interval, upper, distance - radius, at_point[:, 2].copy(), terms)


def _step(surface: Surface, look: _Look, sigma_m: float) -> NDArray[np.float64]:
    """Gauss-Newton step (k, 7) of the knot values, metres."""
    n_knots = len(surface.knots_z_m)
    normal, right = _stiffness(surface, sigma_m)
    weights = tukey_weights(look.residual_m, sigma_m)
    order = np.argsort(look.interval, kind="stable")
    ends = np.searchsorted(look.interval[order], np.arange(n_knots))
    for knot in range(n_knots - 1):
        rows = order[ends[knot] : ends[knot + 1]]
        terms, upper = look.terms[rows], look.upper[rows, None]
        design = np.hstack([(1.0 - upper) * terms, upper * terms])
        weighted = design * weights[rows, None]
        block = slice(TERMS * knot, TERMS * (knot + 2))
        normal[block, block] += weighted.T @ design
        right[block] += weighted.T @ look.residual_m[rows]
    return np.asarray(np.linalg.solve(normal, right).reshape(n_knots, TERMS))


def _stiffness(surface: Surface, sigma_m: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normal matrix and right side of the prior, in units in which a point weighs 1."""
    n_knots = len(surface.knots_z_m)
    radius_m = float(np.mean(surface.values_m[:, 2]))
    bend, change, size = (
        np.diff(np.eye(n_knots), 2, axis=0),
        np.diff(np.eye(n_knots), axis=0),
        np.eye(n_knots),
    )
    smooth = bend.T @ bend / (BEND_SD_RADII * radius_m) ** 2
    lobes = (
        size / (LOBE_SD_RADII * radius_m) ** 2 + change.T @ change / (LOBE_CHANGE_SD_RADII * radius_m) ** 2
    )
    axis_or_radius = np.diag((np.arange(TERMS) < 3).astype(np.float64))
    normal = np.kron(smooth, axis_or_radius) + np.kron(lobes, np.eye(TERMS) - axis_or_radius)
    normal *= POINTS_PER_INDEPENDENT_ONE * sigma_m**2
    return normal, -normal @ surface.values_m.ravel()
