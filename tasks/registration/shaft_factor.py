"""The shaft as an observation: every station sees one axis and one radius at each height.

It ties stations that share no plane because they see opposite sides. It is weighed lightly: no shaft is as round as it is
planned, and what is out of round must not tell a scanner what is plumb.
"""

from collections.abc import Sequence
from dataclasses import dataclass
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
    station = np.repeat(np.arange(n), counts)
    fit = _fit(np.concatenate(placed), station, n, shaft)
    by_pose = np.hstack(
        [np.cross(fit.points_m - np.array([p.position_m for p in poses])[station], fit.normals), fit.normals]
    )
    return _eliminate(fit, by_pose, station, n)


@dataclass(frozen=True, slots=True)
class _Fit:
    """Points (m, 3), outward normals (m, 3), design (m, q) of axis and radii, residuals (m,), weights (m,) in 1 / m2."""

    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    design: NDArray[np.float64]
    residuals_m: NDArray[np.float64]
    weights: NDArray[np.float64]


def _fit(points_m: NDArray[np.float64], station: NDArray[np.int64], n: int, shaft: ShaftPoints) -> _Fit:
    """Fit a bent axis and a radius at each height to the points of all stations, every station counting the same."""
    low, high = shaft.seen.shaft_z_m
    middle = (low + high) / 2.0
    height = (points_m[:, 2] - middle) / (high - low)
    powers = height[:, None] ** np.arange(3)
    knots = np.linspace(low, high, KNOTS)
    hats = _hats(points_m[:, 2], knots)
    radii = np.interp(knots, shaft.seen.shaft_z_m, shaft.seen.radius_m)
    axis = np.zeros((3, 2))
    axis[0] = shaft.seen.base_xy_m
    sigma = BESIDE_M
    for _ in range(REFITS):
        away = points_m[:, :2] - powers @ axis
        distance = np.hypot(*away.T)
        outward = away / distance[:, None]
        residual = distance - hats @ radii
        design = -np.hstack([powers * outward[:, :1], powers * outward[:, 1:], hats])
        weight = tukey_weights(residual, sigma) / np.bincount(station, minlength=n)[station]
        normal = design.T @ (design * weight[:, None])
        normal += RIDGE * np.trace(normal) * np.eye(len(normal))
        step = -np.linalg.solve(normal, design.T @ (weight * residual))
        axis += step[:6].reshape(2, 3).T
        radii += step[6:]
        sigma = max(mad_sigma(residual + design @ step), FORM_SIGMA_M)
    residual = residual + design @ step
    taper = np.interp(points_m[:, 2], knots, np.gradient(radii, knots))
    slope = np.einsum(
        "ij,ij->i", outward, np.column_stack([powers[:, 0], 2.0 * height]) @ axis[1:] / (high - low)
    )
    normals = np.column_stack([outward, -taper - slope])
    information = FORM_BLOCKS / sigma**2
    weights = information * tukey_weights(residual, sigma) / np.bincount(station, minlength=n)[station]
    return _Fit(points_m, normals, design, residual, weights)


def _hats(z_m: NDArray[np.float64], knots_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Linear interpolation between knots as a matrix (m, k)."""
    return np.column_stack([np.interp(z_m, knots_m, unit) for unit in np.eye(len(knots_m))])


def _eliminate(fit: _Fit, by_pose: NDArray[np.float64], station: NDArray[np.int64], n: int) -> ShaftEquations:
    q = fit.design.shape[1]
    poses, mixed, vector = np.zeros((SIX * n, SIX * n)), np.zeros((SIX * n, q)), np.zeros(SIX * n)
    weighted = by_pose * fit.weights[:, None]
    for i in range(n):
        own = station == i
        rows = slice(SIX * i, SIX * i + SIX)
        poses[rows, rows] = weighted[own].T @ by_pose[own]
        mixed[rows] = weighted[own].T @ fit.design[own]
        vector[rows] = -weighted[own].T @ fit.residuals_m[own]
    nuisance = fit.design.T @ (fit.design * fit.weights[:, None])
    nuisance += RIDGE * np.trace(nuisance) * np.eye(q)
    right = -fit.design.T @ (fit.weights * fit.residuals_m)
    matrix = poses - mixed @ np.linalg.solve(nuisance, mixed.T)
    on_shaft = np.bincount(station[fit.weights > 0.0], minlength=n)
    return ShaftEquations(matrix, vector - mixed @ np.linalg.solve(nuisance, right), on_shaft)
