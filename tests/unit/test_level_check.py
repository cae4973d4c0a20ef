import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD
from tasks.level_check import check_levels, worst_suspect
from tasks.preprocessing import ShaftModel

MODEL = ShaftModel(0.0, 0.0, 0.007, -0.007, (2.0, 102.0), (4.6, 2.7), (0.0, 0.0), (0.0, 0.0), 0.01)
LEVEL_RAD = 2.9 * ARCSEC_RAD


def half_shaft(
    rng: np.random.Generator, azimuth_rad: float, level: NDArray[np.float64]
) -> NDArray[np.float64]:
    """What a station at that azimuth sees of the shaft, its level off by ``level`` (lean east, north)."""
    n = 20_000
    z = rng.uniform(2.0, 102.0, n)
    around = azimuth_rad + rng.uniform(-1.4, 1.4, n)
    radius = MODEL.radius_at(z) + 0.012 * rng.normal(size=n)
    xy = MODEL.axis_at(z) + radius[:, None] * np.column_stack([np.sin(around), np.cos(around)])
    return np.column_stack([xy + z[:, None] * level, z])


def epoch(
    seed: int, levels_arcsec: list[tuple[float, float]]
) -> tuple[NDArray[np.float64], NDArray[np.uint16]]:
    rng = np.random.default_rng(seed)
    n = len(levels_arcsec)
    seen = [
        half_shaft(rng, 2 * np.pi * i / n, ARCSEC_RAD * np.array(level))
        for i, level in enumerate(levels_arcsec)
    ]
    return np.concatenate(seen), np.repeat(np.arange(n, dtype=np.uint16), [len(s) for s in seen])


def test_the_station_that_is_out_of_level_is_named_with_its_error() -> None:
    points, stations = epoch(1, [(0, 0), (0, 0), (30, -40), (0, 0), (0, 0), (0, 0)])
    checks = check_levels(points, stations, MODEL, [LEVEL_RAD] * 6)
    assert worst_suspect(checks) == 2
    found = np.array([checks[2].lean_east, checks[2].lean_north], float) / ARCSEC_RAD
    # the noise of 20,000 points on half a shaft leaves 1 to 2 arc seconds
    assert found == pytest.approx([30, -40], abs=5)


@pytest.mark.parametrize("seed", range(5))
def test_levels_within_their_sigma_make_nobody_suspect(seed: int) -> None:
    levels = 2.9 * np.random.default_rng(100 + seed).normal(size=(8, 2))
    points, stations = epoch(seed, [tuple(level) for level in levels])
    assert worst_suspect(check_levels(points, stations, MODEL, [LEVEL_RAD] * 8)) is None


def test_ladder_in_front_of_one_station_is_no_level_error() -> None:
    points, stations = epoch(3, [(0, 0)] * 4)
    rng = np.random.default_rng(4)
    on_ladder = (stations == 1) & (rng.uniform(size=len(points)) < 0.04)
    outward = points[on_ladder, :2] - MODEL.axis_at(points[on_ladder, 2])
    points[on_ladder, :2] += 0.1 * outward / np.linalg.norm(outward, axis=1)[:, None]
    assert worst_suspect(check_levels(points, stations, MODEL, [LEVEL_RAD] * 4)) is None


def test_one_station_alone_cannot_be_checked() -> None:
    points, stations = epoch(1, [(100, 0)])
    (check,) = check_levels(points, stations, MODEL, [LEVEL_RAD])
    assert check.chi2 is None
    assert worst_suspect([check]) is None


def test_station_with_few_points_is_not_judged() -> None:
    points, stations = epoch(1, [(0, 0), (100, 0)])
    few = (stations == 0) | (np.arange(len(points)) % 100 == 0)
    checks = check_levels(points[few], stations[few], MODEL, [LEVEL_RAD] * 2)
    assert checks[1].chi2 is None
    assert checks[0].chi2 is not None
