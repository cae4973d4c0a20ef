from dataclasses import replace

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.simulation import (
    PERFECT_SCANNER,
    Scanner,
    Setup,
    build_site,
    draw_station_places,
    draw_terrain,
    set_up_station,
)
from tests.unit.simulation.conftest import SmallCampaign


def test_stations_stand_200_to_300_m_away_all_around() -> None:
    places_m = draw_station_places(8, np.random.default_rng(2))
    distance_m = np.hypot(*places_m.T)
    azimuth_deg = np.sort(np.degrees(np.arctan2(*places_m.T)) % 360.0)
    gaps_deg = np.diff(np.append(azimuth_deg, azimuth_deg[0] + 360.0))
    assert 200.0 <= distance_m.min() <= distance_m.max() <= 300.0
    # even ones are 45 deg apart; each strays by up to 0.3 of that
    assert 45.0 * 0.4 <= gaps_deg.min() <= gaps_deg.max() <= 45.0 * 1.6
    assert np.ptp(gaps_deg) > 5.0


def test_campaign_without_a_station_is_refused() -> None:
    with pytest.raises(ShapeError, match="at least 1 station; got 0"):
        draw_station_places(0, np.random.default_rng(2))


def test_axis_ahead_of_a_levelled_scanner_points_to_its_heading() -> None:
    setup = Setup("ST01", np.array([10.0, 20.0, 2.0]), np.radians(90.0), 0.0, 0.0, np.zeros(3), 0.0)
    ahead_m = setup.to_site(np.array([[0.0, 7.0, 0.0]]))
    assert ahead_m == pytest.approx(np.array([[17.0, 20.0, 2.0]]), abs=1e-12)


def test_level_error_about_east_lifts_what_lies_north() -> None:
    setup = Setup("ST01", np.zeros(3), 0.0, 1e-3, 0.0, np.zeros(3), 0.0)
    assert setup.to_site(np.array([[0.0, 100.0, 0.0]]))[0, 2] == pytest.approx(0.1, rel=1e-5)


def test_stated_sigmas_match_the_scatter_of_many_set_ups() -> None:
    rng = np.random.default_rng(4)
    terrain, scanner, place_m = draw_terrain(rng), Scanner(), np.array([200.0, 100.0])
    setups = [set_up_station("ST01", place_m, terrain, scanner, rng) for _ in range(2000)]
    off_m = np.array([s.stated_position_m - s.position_m for s in setups])
    turned_deg = np.degrees([np.sin(s.stated_heading_rad - s.heading_rad) for s in setups])
    level_deg = np.degrees([[s.level_east_rad, s.level_north_rad] for s in setups])
    # the scatter of a standard deviation over 2000 draws is 1.6 %: four of those
    assert off_m.std(axis=0) == pytest.approx([0.015, 0.015, 0.0225], rel=0.065)
    assert turned_deg.std() == pytest.approx(0.15, rel=0.065)
    assert level_deg.std(axis=0) == pytest.approx([0.0008, 0.0008], rel=0.065)


def test_perfect_crew_states_the_true_pose(small: SmallCampaign) -> None:
    setup = small.perfect[0].setup
    assert setup.stated_position_m == pytest.approx(setup.position_m, abs=0.0)
    assert setup.stated_heading_rad == setup.heading_rad


def test_true_position_is_one_that_single_precision_holds() -> None:
    rng = np.random.default_rng(8)
    setup = set_up_station("ST01", np.array([201.234567, -99.7654321]), draw_terrain(rng), Scanner(), rng)
    assert (setup.position_m.astype(np.float32) == setup.position_m).all()


def test_same_seed_draws_the_same_site(small: SmallCampaign) -> None:
    again = [build_site(small.places_m, np.random.default_rng(1)) for _ in range(2)]
    for (_, mesh), (_, other) in zip(again[0].meshes, again[1].meshes, strict=True):
        assert (mesh.vertices_m == other.vertices_m).all()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_nothing_but_ground_stands_in_a_line_of_sight(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places_m = draw_station_places(8, rng)
    for _, mesh in build_site(places_m, rng).meshes[1:]:
        tops_m = mesh.vertices_m[:, :2]
        for place_m in places_m:
            share = np.clip(tops_m @ place_m / (place_m @ place_m), 0.0, 1.0)
            off_m = np.linalg.norm(tops_m - share[:, None] * place_m, axis=1)
            # the shaft is 4.6 m wide to each side, and stations are set up anew within 4 m
            assert off_m.min() > 8.0


def test_ground_is_at_zero_where_the_structure_stands() -> None:
    assert draw_terrain(np.random.default_rng(6)).height_at(np.zeros(2)) == pytest.approx(0.0, abs=1e-12)


def test_range_noise_grows_with_range_and_has_a_floor() -> None:
    sigma_m = replace(PERFECT_SCANNER, range_sigma_m=0.005).range_sigma_at(np.array([10.0, 100.0, 250.0]))
    assert sigma_m == pytest.approx([0.0025, 0.005, 0.0125])
