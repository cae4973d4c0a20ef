"""The sigma of a point across the surface: its law, and what scanned points really scatter by."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.preprocessing import ShaftModel
from tasks.sight_noise import ScannerNoise, sight_sigmas
from tasks.simulation.scanner import Scanner

CYLINDER = ShaftModel(0.0, 0.0, 0.0, 0.0, (0.0, 100.0), (4.0, 4.0), (0.0, 0.0), (0.0, 0.0), 0.01)
CONE = ShaftModel(
    0.5, -0.3, 0.05, -0.03, (0.0, 50.0, 100.0), (8.0, 4.0, 3.0), (0.4, 0.0, 0.4), (0.0, 0.1, 0.0), 0.01
)
NOISE = ScannerNoise(range_sigma_m=0.005, angle_sigma_rad=2e-5, roughness_m=0.0)
FIRST = np.zeros(1, dtype=np.uint16)


def surface(
    model: ShaftModel, z_m: NDArray[np.float64], azimuth_rad: NDArray[np.float64]
) -> NDArray[np.float64]:
    out = np.column_stack([np.sin(azimuth_rad), np.cos(azimuth_rad)])
    return np.column_stack([model.axis_at(z_m) + model.radius_at(z_m)[:, None] * out, z_m])


def off_surface(model: ShaftModel, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances from the surface along z = const, outward positive."""
    out = points_m[:, :2] - model.axis_at(points_m[:, 2])
    return np.asarray(np.hypot(*out.T) - model.radius_at(points_m[:, 2]))


def measured(
    true_m: NDArray[np.float64], station_m: NDArray[np.float64], noise: ScannerNoise, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Points as a scanner measures them: range along the sight, an angle in each of two directions across it."""
    sight = true_m - station_m
    distance = np.linalg.norm(sight, axis=1, keepdims=True)
    along = sight / distance
    level = np.cross(along, [0.0, 0.0, 1.0])
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    errors = rng.normal(size=(3, len(true_m), 1))
    range_sigma = noise.range_sigma_m * np.maximum(distance / 100.0, 0.5)
    across = noise.angle_sigma_rad * distance
    moved = range_sigma * errors[0] * along + across * (
        errors[1] * level + errors[2] * np.cross(level, along)
    )
    return np.asarray(true_m + moved)


def test_a_sight_along_the_normal_has_the_range_noise_alone() -> None:
    point = surface(CYLINDER, np.array([10.0]), np.array([0.0]))
    station = np.array([[0.0, 204.0, 10.0]])
    assert sight_sigmas(point, FIRST, station, CYLINDER, NOISE) == pytest.approx([0.010], rel=1e-12)


def test_a_grazing_sight_has_the_angle_noise_alone() -> None:
    station = np.array([[200.0, 4.0, 10.0]])
    point = surface(CYLINDER, np.array([10.0]), np.array([0.0]))
    assert sight_sigmas(point, FIRST, station, CYLINDER, NOISE) == pytest.approx([200.0 * 2e-5], rel=1e-12)


def test_roughness_adds_in_squares() -> None:
    point = surface(CYLINDER, np.array([10.0]), np.array([0.0]))
    rough = replace(NOISE, roughness_m=0.0075)
    station = np.array([[0.0, 204.0, 10.0]])
    assert sight_sigmas(point, FIRST, station, CYLINDER, rough) == pytest.approx([0.0125], rel=1e-12)


@pytest.mark.parametrize("distance_m", [5.0, 49.0, 51.0, 300.0])
def test_the_range_noise_is_that_of_the_simulated_scanner(distance_m: float) -> None:
    point = surface(CYLINDER, np.array([10.0]), np.array([0.0]))
    station = np.array([[0.0, 4.0 + distance_m, 10.0]])
    scanner = Scanner(range_sigma_m=0.005).range_sigma_at(np.array([distance_m]))
    assert sight_sigmas(point, FIRST, station, CYLINDER, NOISE) == pytest.approx(scanner, rel=1e-12)


def test_every_point_is_seen_from_its_own_station() -> None:
    points = surface(CYLINDER, np.array([10.0, 10.0]), np.array([0.0, np.pi]))
    stations = np.array([[0.0, 104.0, 10.0], [0.0, -304.0, 10.0]])
    seen = sight_sigmas(points, np.array([0, 1], dtype=np.uint16), stations, CYLINDER, NOISE)
    assert seen == pytest.approx([0.005, 0.015], rel=1e-12)


@pytest.mark.parametrize("station_m", [(60.0, 20.0, 1.6), (-20.0, -25.0, 1.6), (150.0, -220.0, 40.0)])
def test_the_stated_sigma_is_the_scatter_across_a_leaning_cone(station_m: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(8)
    station = np.array(station_m)
    noise = ScannerNoise(range_sigma_m=0.004, angle_sigma_rad=1e-4)
    toward = np.arctan2(station[0], station[1])
    true = surface(CONE, rng.uniform(1.0, 99.0, 40_000), toward + rng.uniform(-1.45, 1.45, 40_000))
    # away from the knot, where the surface has no one normal
    true = true[np.abs(true[:, 2] - 50.0) > 1.0]
    found = measured(true, station, replace(noise, roughness_m=0.0), rng)
    slope = (off_surface(CONE, true + np.array([0.0, 0.0, 1e-3])) - off_surface(CONE, true)) / 1e-3
    off = off_surface(CONE, found) / np.sqrt(1.0 + slope**2)
    sigma = sight_sigmas(
        true,
        np.zeros(len(true), dtype=np.uint16),
        station[None],
        CONE,
        replace(noise, roughness_m=0.0),
    )
    for part in np.array_split(np.argsort(sigma), 5):
        # 8,000 points tell a standard deviation to 0.8 %
        assert np.std(off[part] / sigma[part]) == pytest.approx(1.0, abs=0.03)


def test_where_a_cloud_is_cut_into_parts_does_not_show() -> None:
    rng = np.random.default_rng(3)
    n = 70_001
    points = surface(CONE, rng.uniform(0.0, 100.0, n), rng.uniform(-np.pi, np.pi, n))
    stations = np.array([[90.0, 0.0, 1.6], [-40.0, 70.0, 1.6]])
    index = rng.integers(0, 2, n)
    whole = sight_sigmas(points, index, stations, CONE, NOISE)
    last = sight_sigmas(points[-10:], index[-10:], stations, CONE, NOISE)
    assert whole[-10:] == pytest.approx(last, rel=1e-14)


def test_a_station_that_does_not_exist_is_misuse() -> None:
    point = surface(CYLINDER, np.array([10.0]), np.array([0.0]))
    with pytest.raises(ShapeError, match="station indices below 1; got 1"):
        sight_sigmas(point, np.ones(1, dtype=np.uint16), np.zeros((1, 3)), CYLINDER, NOISE)
    with pytest.raises(ShapeError, match="needs points"):
        sight_sigmas(point, FIRST, np.zeros(3), CYLINDER, NOISE)
