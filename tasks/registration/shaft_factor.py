"""The shaft as an observation: every station sees one axis and one radius at each height.

It ties stations that share no plane because they see opposite sides. It is weighed lightly: no shaft is as round as it is
planned, and what is out of round must not tell a scanner what is plumb.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.geometry.robust import mad_sigma, tukey_weights
from tasks.registration.planar import ScanPlanes
from tasks.registration.sighting import UPRIGHT
from tasks.registration.station import ShaftHint, StationPose

BESIDE_M: Final = 2.0
"""Points that near to the rough shaft belong to it until the fit says otherwise."""

MOST_POINTS: Final = 4000
LEAST_POINTS: Final = 200
FORM_SIGMA_M: Final = 0.01
"""How far a shaft is out of the model at least: out of round, formwork, patches."""

FORM_BLOCKS: Final = 10.0
"""So many independent pieces of form a station sees: with it one station knows the axis to 4 mm and its lean to half a
minute of arc, which is far looser than a level of a few seconds."""

KNOTS: Final = 12
REFITS: Final = 6
RIDGE: Final = 1e-9


@dataclass(frozen=True, slots=True)
class ShaftPoints:
    """What every station sees of the shaft (m_i, 3), scanner frames; and where it is at mid height, and how wide."""

    points_m: tuple[NDArray[np.float64], ...]
    seen: ShaftHint


@dataclass(frozen=True, slots=True)
class ShaftEquations:
    """Normal equations (6n, 6n) and (6n,) of the poses, axis and radii eliminated; points (n,) that lie on the shaft."""

    matrix: NDArray[np.float64]
    vector: NDArray[np.float64]
    n_points: NDArray[np.int64]


def shaft_points(planes: Sequence[ScanPlanes], poses: Sequence[StationPose], seen: ShaftHint) -> ShaftPoints:
    """Choose the points around the shaft, ``seen`` at mid height, as the stations are placed now."""
    at_m, hint = np.asarray(seen.base_xy_m, dtype=np.float64), seen
    low, high = hint.shaft_z_m
    chosen = []
    for own, pose in zip(planes, poses, strict=True):
        placed = pose.to_site(own.fine.points_m)
        near = np.hypot(*(placed[:, :2] - at_m).T) < max(hint.radius_m) + BESIDE_M
        near &= (placed[:, 2] > low) & (placed[:, 2] < high) & (np.abs(own.fine.normals[:, 2]) < UPRIGHT)
        points = own.fine.points_m[near]
        chosen.append(points[:: max(1, len(points) // MOST_POINTS)])
    return ShaftPoints(tuple(chosen), seen)


def shaft_equations(shaft: ShaftPoints, poses: Sequence[StationPose]) -> ShaftEquations:
    """Linearise the distances of all points from the common shaft at the present poses."""
    n = len(poses)
    counts = np.array([len(points) for points in shaft.points_m])
    nothing = ShaftEquations(np.zeros((SIX * n, SIX * n)), np.zeros(SIX * n), np.zeros(n, np.int64))
    if np.count_nonzero(counts >= LEAST_POINTS) < 2:
        return nothing
    placed = [pose.to_site(points) for pose, points in zip(poses, shaft.points_m, strict=True)]
    fit = _fit(np.concatenate(placed), np.repeat(np.arange(n), counts), n, shaft)
    return _eliminate(fit, np.cumsum([0, *counts]), poses)


@dataclass(frozen=True, slots=True)
class _Fit:
    """Points (m, 3), their heights (m,) in shares of the shaft from its middle, and the knots beside them with shares (m,).

    Then directions (m, 2) from the axis, outward normals (m, 3), residuals (m,), weights (m,) in 1 / m2.
    """

    points_m: NDArray[np.float64]
    height: NDArray[np.float64]
    beside: tuple[NDArray[np.int64], NDArray[np.float64]]
    outward: NDArray[np.float64]
    normals: NDArray[np.float64]
    residuals_m: NDArray[np.float64]
    weights: NDArray[np.float64]


def _fit(points_m: NDArray[np.float64], station: NDArray[np.int64], n: int, shaft: ShaftPoints) -> _Fit:
    """Fit a bent axis and a radius at each height to the points of all stations, every station counting the same."""
    from tasks.registration.shaft_kernel import design_sums, knots_beside, residuals_off, stepped  # noqa: PLC0415 (slow to import)

    low, high = shaft.seen.shaft_z_m
    middle = (low + high) / 2.0
    height = (points_m[:, 2] - middle) / (high - low)
    knots = np.linspace(low, high, KNOTS)
    beside = knots_beside(np.ascontiguousarray(points_m[:, 2]), knots)
    radii = np.interp(knots, shaft.seen.shaft_z_m, shaft.seen.radius_m)
    axis = np.zeros((3, 2))
    axis[0] = shaft.seen.base_xy_m
    sigma, share = BESIDE_M, 1.0 / np.bincount(station, minlength=n)[station]
    for _ in range(REFITS):
        residual, outward = residuals_off(points_m, height, beside, axis, radii)
        weight = tukey_weights(residual, sigma) * share
        normal, right = design_sums(outward, height, beside, weight, residual, KNOTS)
        step = np.asarray(np.linalg.solve(_ridged(normal), right), dtype=np.float64)
        axis += step[:6].reshape(2, 3).T
        radii += step[6:]
        residual = stepped(outward, height, beside, residual, step)
        sigma = max(mad_sigma(residual), FORM_SIGMA_M)
    taper = np.interp(points_m[:, 2], knots, np.gradient(radii, knots))
    bend = np.column_stack([np.ones_like(height), 2.0 * height]) @ axis[1:] / (high - low)
    normals = np.column_stack([outward, -taper - np.einsum("ij,ij->i", outward, bend)])
    weights = FORM_BLOCKS / sigma**2 * tukey_weights(residual, sigma) * share
    return _Fit(points_m, height, beside, outward, normals, residual, weights)


def _ridged(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Keep a normal matrix (q, q) from being singular where no point is."""
    return np.asarray(normal + RIDGE * np.trace(normal) * np.eye(len(normal)))


def _eliminate(fit: _Fit, begins: NDArray[np.int64], poses: Sequence[StationPose]) -> ShaftEquations:
    """Normal equations of the poses alone; the points of station i start at ``begins[i]``."""
    from tasks.registration.shaft_kernel import AXIS_TERMS, design_sums, station_sums  # noqa: PLC0415 (slow to import)

    n, q = len(poses), AXIS_TERMS + KNOTS
    own, mixed, vector = np.zeros((SIX * n, SIX * n)), np.zeros((SIX * n, q)), np.zeros(SIX * n)
    for i, pose in enumerate(poses):
        rows, part = slice(SIX * i, SIX * i + SIX), slice(begins[i], begins[i + 1])
        own[rows, rows], mixed[rows], vector[rows] = station_sums(
            fit.points_m[part] - pose.position_m,
            fit.normals[part],
            fit.outward[part],
            fit.height[part],
            (fit.beside[0][part], fit.beside[1][part]),
            fit.weights[part],
            fit.residuals_m[part],
            KNOTS,
        )
    nuisance, right = design_sums(fit.outward, fit.height, fit.beside, fit.weights, fit.residuals_m, KNOTS)
    nuisance = _ridged(nuisance)
    matrix = own - mixed @ np.linalg.solve(nuisance, mixed.T)
    on_shaft = np.array([np.count_nonzero(fit.weights[a:b]) for a, b in pairwise(begins)])
    return ShaftEquations(matrix, vector - mixed @ np.linalg.solve(nuisance, right), on_shaft)
