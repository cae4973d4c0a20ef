from dataclasses import replace

import numpy as np
import pytest

from tasks.registration import ShaftHint
from tasks.registration.planar import planes_of_scan
from tasks.registration.sighting import sight_shaft, walls
from tests.unit.registration.conftest import HINT, SeenSite
from tests.unit.registration.courtyard import draw_courtyard

TALL = ShaftHint((0.0, 0.0), (0.0, 60.0), (3.0, 2.0))


def half_shaft(rng: np.random.Generator, east_m: float, north_m: float) -> np.ndarray:
    """The near half of a tapered shaft, seen from the origin."""
    n = 8000
    z = rng.uniform(-1.5, 58.0, n)
    azimuth = np.arctan2(east_m, north_m) + np.pi + rng.uniform(-1.3, 1.3, n)
    radius = np.interp(z, (0.0, 60.0), (3.0, 2.0))
    points = np.column_stack([east_m + radius * np.sin(azimuth), north_m + radius * np.cos(azimuth), z])
    return np.asarray(points + 0.003 * rng.normal(size=points.shape))


def test_every_station_sights_the_shaft_where_it_stands(eight: SeenSite) -> None:
    for station, planes in zip(eight.stations, eight.planes, strict=True):
        sighting = sight_shaft(walls(planes), HINT)[0]
        seen = station.setup.to_site(np.r_[sighting.centre_m, 0.0][None])[0, :2]
        # the axis leans by 0.6 m to mid height, and is not seen over the same heights from everywhere
        assert seen == pytest.approx([0.37, -0.35], abs=0.6)


def test_distance_and_azimuth_are_those_of_the_axis() -> None:
    rng = np.random.default_rng(1)
    found = sight_shaft(walls(planes_of_scan(half_shaft(rng, 60.0, -80.0))), TALL)
    assert len(found) == 1
    assert found[0].distance_m == pytest.approx(100.0, abs=0.05)
    assert found[0].azimuth_rad == pytest.approx(np.arctan2(60.0, -80.0), abs=5e-4)


def test_two_shafts_are_both_sighted_the_one_with_more_points_first() -> None:
    rng = np.random.default_rng(2)
    scan = np.vstack([half_shaft(rng, 60.0, -80.0)[::4], half_shaft(rng, -50.0, 90.0)])
    first, second = sight_shaft(walls(planes_of_scan(scan)), TALL)
    assert first.centre_m == pytest.approx([-50.0, 90.0], abs=0.1)
    assert second.centre_m == pytest.approx([60.0, -80.0], abs=0.1)
    assert first.n_points > second.n_points


def test_low_walls_are_no_shaft() -> None:
    scan = draw_courtyard(1).scans[0].points_m
    assert sight_shaft(walls(planes_of_scan(scan)), TALL) == ()


def test_the_corner_of_a_tower_is_no_round_shaft() -> None:
    rng = np.random.default_rng(3)
    along, z = rng.uniform(0.0, 9.0, 8000), rng.uniform(0.0, 58.0, 8000)
    half = np.arange(8000) % 2 == 0
    corner = np.column_stack([np.where(half, 50.0 + along, 50.0), np.where(half, 50.0, 50.0 + along), z])
    planes = planes_of_scan(corner + 0.003 * rng.normal(size=corner.shape))
    assert sight_shaft(walls(planes), TALL) == ()


def test_a_scan_without_walls_sights_nothing() -> None:
    assert sight_shaft(np.empty((0, 3)), TALL) == ()


def test_where_the_hint_says_it_stands_does_not_matter() -> None:
    planes = planes_of_scan(half_shaft(np.random.default_rng(1), 60.0, -80.0))
    here = sight_shaft(walls(planes), TALL)
    there = sight_shaft(walls(planes), replace(TALL, base_xy_m=(1e4, -1e4)))
    assert np.array_equal(here[0].centre_m, there[0].centre_m)
