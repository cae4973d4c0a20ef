"""The sums of the common shaft against the same fit with full matrices, in plain numpy."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.geometry.robust import mad_sigma, tukey_weights
from tasks.registration import StationPose
from tasks.registration.shaft_factor import (
    BESIDE_M,
    FORM_BLOCKS,
    FORM_SIGMA_M,
    KNOTS,
    REFITS,
    RIDGE,
    ShaftPoints,
    shaft_equations,
)
from tests.unit.registration.test_shaft_factor import HINT, seen_from, twisting_oval

Equations = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]


def by_poses(
    arms_m: NDArray[np.float64], normals: NDArray[np.float64], station: NDArray[np.intp], n: int
) -> NDArray[np.float64]:
    """Derivatives (m, 6 n) of the residuals by turns and shifts of the stations."""
    design = np.zeros((len(arms_m), 6 * n))
    for i in range(n):
        own = station == i
        design[own, 6 * i : 6 * i + 6] = np.hstack([np.cross(arms_m[own], normals[own]), normals[own]])
    return design


def in_full(shaft: ShaftPoints, poses: list[StationPose]) -> Equations:
    n, counts = len(poses), [len(own) for own in shaft.points_m]
    station = np.repeat(np.arange(n), counts)
    points = np.concatenate([pose.to_site(own) for pose, own in zip(poses, shaft.points_m, strict=True)])
    low, high = shaft.seen.shaft_z_m
    height = (points[:, 2] - (low + high) / 2.0) / (high - low)
    powers, knots = height[:, None] ** np.arange(3), np.linspace(low, high, KNOTS)
    hats = np.column_stack([np.interp(points[:, 2], knots, unit) for unit in np.eye(KNOTS)])
    radii = np.interp(knots, shaft.seen.shaft_z_m, shaft.seen.radius_m)
    axis, sigma = np.zeros((3, 2)), BESIDE_M
    axis[0] = shaft.seen.base_xy_m
    share = 1.0 / np.array(counts)[station]
    for _ in range(REFITS):
        away = points[:, :2] - powers @ axis
        distance = np.hypot(*away.T)
        outward = away / distance[:, None]
        residual = distance - hats @ radii
        design = -np.hstack([powers * outward[:, :1], powers * outward[:, 1:], hats])
        weight = tukey_weights(residual, sigma) * share
        normal = design.T @ (design * weight[:, None])
        step = -np.linalg.solve(
            normal + RIDGE * np.trace(normal) * np.eye(len(normal)), design.T @ (weight * residual)
        )
        axis, radii = axis + step[:6].reshape(2, 3).T, radii + step[6:]
        residual = residual + design @ step
        sigma = max(mad_sigma(residual), FORM_SIGMA_M)
    taper = np.interp(points[:, 2], knots, np.gradient(radii, knots))
    bend = np.column_stack([powers[:, 0], 2.0 * height]) @ axis[1:] / (high - low)
    normals = np.column_stack([outward, -taper - np.einsum("ij,ij->i", outward, bend)])
    weights = FORM_BLOCKS / sigma**2 * tukey_weights(residual, sigma) * share
    by_pose = by_poses(points - np.array([pose.position_m for pose in poses])[station], normals, station, n)
    nuisance = design.T @ (design * weights[:, None])
    nuisance += RIDGE * np.trace(nuisance) * np.eye(len(nuisance))
    mixed = by_pose.T @ (design * weights[:, None])
    matrix = by_pose.T @ (by_pose * weights[:, None]) - mixed @ np.linalg.solve(nuisance, mixed.T)
    right = -design.T @ (weights * residual)
    vector = -by_pose.T @ (weights * residual) - mixed @ np.linalg.solve(nuisance, right)
    return matrix, vector, np.bincount(station[weights > 0.0], minlength=n)


@pytest.mark.parametrize("azimuths", [(0.2, 0.2 + np.pi), (0.0, 1.1, 2.5, 4.0)])
def test_sums_are_those_of_full_matrices(azimuths: tuple[float, ...]) -> None:
    shaft, poses = seen_from(azimuths, 1500)
    # noise that makes outliers, points beyond both ends, and one station with fewer points
    rng = np.random.default_rng(6)
    rough = [own + twisting_oval(own[:, 0], own[:, 2])[:, None] for own in shaft.points_m]
    rough[0] = rough[0][:700]
    rough[0][::20] += rng.normal(size=rough[0][::20].shape)
    shaft = ShaftPoints(tuple(rough), HINT)
    ours = shaft_equations(shaft, poses)
    matrix, vector, on_shaft = in_full(shaft, poses)
    size = np.sqrt(np.maximum(np.diag(matrix), 1e-6 * np.diag(matrix).max()))
    assert ours.matrix / np.outer(size, size) == pytest.approx(matrix / np.outer(size, size), abs=1e-8)
    assert ours.vector / size == pytest.approx(vector / size, abs=1e-8 * np.abs(vector / size).max())
    assert np.array_equal(ours.n_points, on_shaft)
    assert on_shaft[0] < 700
