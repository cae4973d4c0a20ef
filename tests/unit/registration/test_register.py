from dataclasses import replace

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.conventions import ARCSEC_RAD, rotation_site_scanner
from tasks.geometry.rotations import rotation_from_vector
from tasks.registration import Registration, StationScan, register_stations, registered_cloud
from tests.unit.registration.conftest import SIGMAS, Site, bare_cylinder


def heading_errors_arcsec(site: Site, registration: Registration) -> np.ndarray:
    found = np.array([diagnosis.heading_rad for diagnosis in registration.diagnoses])
    true = np.array([station.setup.heading_rad for station in site.stations])
    return (np.mod(found - true + np.pi, 2 * np.pi) - np.pi) / ARCSEC_RAD


def test_headings_come_out_ten_times_better_than_stated(site: Site, registration: Registration) -> None:
    stated = np.array([s.setup.stated_heading_rad - s.setup.heading_rad for s in site.stations]) / ARCSEC_RAD
    assert np.sqrt(np.mean(stated**2)) > 200  # the stated sigma is 540"
    # five GNSS positions of 15 mm at 250 m leave about 10" of common heading
    assert np.sqrt(np.mean(heading_errors_arcsec(site, registration) ** 2)) < 40


def test_level_stays_within_what_the_instrument_states(registration: Registration) -> None:
    for diagnosis in registration.diagnoses:
        assert np.hypot(diagnosis.level_east_rad, diagnosis.level_north_rad) < 3 * SIGMAS.level_rad


def test_level_of_the_network_is_not_known_better_than_its_instruments(registration: Registration) -> None:
    n = len(registration.poses)
    mean = np.tile(np.eye(6)[0], n) / n
    sigma = np.sqrt(mean @ registration.covariance @ mean)
    # scans compare stations with each other; plumb comes from the levels alone
    assert sigma >= 0.95 * SIGMAS.level_rad / np.sqrt(n)


def test_every_station_of_a_good_epoch_is_ok(registration: Registration) -> None:
    assert [d.state for d in registration.diagnoses] == ["ok"] * len(registration.poses)
    assert all(d.overlap is not None and d.overlap > 0.05 for d in registration.diagnoses)


def test_turning_and_shifting_the_site_moves_the_poses_with_it(
    site: Site, registration: Registration
) -> None:
    turn_rad, shift = 0.7, np.array([1000.0, -2000.0, 50.0])
    turn = rotation_site_scanner(turn_rad)
    moved = [
        replace(scan, position_m=turn @ scan.position_m + shift, heading_rad=scan.heading_rad + turn_rad)
        for scan in site.scans
    ]
    again = register_stations(moved, SIGMAS)
    for before, after in zip(registration.poses, again.poses, strict=True):
        # matches change by rounding only; 0.1 mm and 0.5" are far below the sigmas
        assert after.position_m == pytest.approx(turn @ before.position_m + shift, abs=1e-4)
        assert after.rotation == pytest.approx(turn @ before.rotation, abs=2.5e-6)


def test_the_order_of_stations_does_not_matter(site: Site, registration: Registration) -> None:
    again = register_stations(site.scans[::-1], SIGMAS)
    for before, after in zip(registration.poses, reversed(again.poses), strict=True):
        assert after.station == before.station
        assert after.position_m == pytest.approx(before.position_m, abs=1e-6)


def test_a_heading_wrong_by_degrees_makes_the_station_suspect(site: Site) -> None:
    wrong = replace(site.scans[1], heading_rad=site.scans[1].heading_rad + np.radians(1.2))
    diagnosis = register_stations((site.scans[0], wrong, *site.scans[2:]), SIGMAS).diagnoses[1]
    assert diagnosis.state == "suspect"
    assert diagnosis.reason is not None
    assert "heading" in diagnosis.reason or "planes match" in diagnosis.reason


def test_a_lone_station_keeps_the_pose_that_is_stated(site: Site) -> None:
    alone = register_stations(site.scans[:1], SIGMAS)
    assert alone.poses[0].position_m == pytest.approx(site.scans[0].position_m, abs=1e-12)
    assert alone.diagnoses[0].overlap is None
    assert np.sqrt(np.diag(alone.covariance)) == pytest.approx(
        [SIGMAS.level_rad] * 2 + [SIGMAS.heading_rad, 0.015, 0.015, 0.0225]
    )


def test_scans_that_share_nothing_stay_at_their_priors_and_say_so(site: Site) -> None:
    far = replace(site.scans[1], position_m=site.scans[1].position_m + 5000.0)
    registration = register_stations((site.scans[0], far), SIGMAS)
    assert [d.state for d in registration.diagnoses] == ["suspect", "suspect"]
    assert all(
        d.reason is not None and "0 % of its planes match any other station" in d.reason
        for d in registration.diagnoses
    )
    assert all(d.weakest_direction is None for d in registration.diagnoses)


def test_yaw_about_a_bare_round_shaft_is_named_as_the_weakest_direction_and_kept() -> None:
    rng = np.random.default_rng(5)
    noise = 0.002
    scans = [
        StationScan(name, bare_cylinder(rng) + noise * rng.normal(size=(40_000, 3)), np.zeros(3), 0.0)
        for name in ("ST01", "ST02")
    ]
    registration = register_stations(scans, SIGMAS)
    for diagnosis in registration.diagnoses:
        assert diagnosis.weakest_direction in {"heading", "shift up"}
        # the data say nothing of it, so its sigma is nearly the stated one; the noise of normals feigns a little
        assert diagnosis.sigma_heading_rad == pytest.approx(SIGMAS.heading_rad, rel=0.15)


def test_a_registered_cloud_is_taken_as_it_is_but_not_better_than_its_level() -> None:
    registration = registered_cloud("registered", SIGMAS)
    points = np.array([[1.0, 2.0, 3.0]])
    assert registration.poses[0].to_site(points) == pytest.approx(points)
    assert np.sqrt(registration.covariance[0, 0]) == pytest.approx(SIGMAS.level_rad)


def test_an_epoch_without_scans_is_refused() -> None:
    with pytest.raises(ShapeError, match="at least one scan; got none"):
        register_stations([], SIGMAS)


def test_same_scans_give_the_same_poses_to_the_last_bit(site: Site, registration: Registration) -> None:
    again = register_stations(site.scans, SIGMAS)
    assert np.array_equal(again.covariance, registration.covariance)
    assert all(
        np.array_equal(a.rotation, b.rotation) for a, b in zip(again.poses, registration.poses, strict=True)
    )


def test_rotation_vectors_turn_by_their_length() -> None:
    rotation = rotation_from_vector(np.array([0.0, 0.0, np.pi / 2]))
    assert rotation @ np.array([1.0, 0.0, 0.0]) == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)
