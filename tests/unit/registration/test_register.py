from dataclasses import replace

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.conventions import ARCSEC_RAD, rotation_site_scanner
from tasks.geometry.failure import FitFailure
from tasks.geometry.rotations import rotation_from_vector
from tasks.registration import (
    Registration,
    StationScan,
    register_stations,
    registered_cloud,
)
from tests.unit.registration.conftest import HINT, SeenSite, Site, succeed
from tests.unit.registration.courtyard import SIGMAS, Courtyard


def heading_errors_arcsec(site: Site | SeenSite, registration: Registration) -> np.ndarray:
    found = {diagnosis.station: diagnosis.heading_rad for diagnosis in registration.diagnoses}
    true = {station.setup.station: station.setup.heading_rad for station in site.stations}
    off = np.array([found[name] - true[name] for name in found])
    return (np.mod(off + np.pi, 2 * np.pi) - np.pi) / ARCSEC_RAD


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
    assert registration.refused == ()


def test_turning_and_shifting_the_site_moves_the_poses_with_it(
    site: Site, registration: Registration
) -> None:
    turn_rad, shift = 0.7, np.array([1000.0, -2000.0, 50.0])
    turn = rotation_site_scanner(turn_rad)
    moved = [
        replace(scan, position_m=turn @ scan.position_m + shift, heading_rad=scan.heading_rad + turn_rad)
        for scan in site.scans
    ]
    again = succeed(register_stations(moved, SIGMAS))
    for before, after in zip(registration.poses, again.poses, strict=True):
        # matches change by rounding only; 0.1 mm and 0.5" are far below the sigmas
        assert after.position_m == pytest.approx(turn @ before.position_m + shift, abs=1e-4)
        assert after.rotation == pytest.approx(turn @ before.rotation, abs=2.5e-6)


def test_the_order_of_stations_does_not_matter(site: Site, registration: Registration) -> None:
    again = succeed(register_stations(site.scans[::-1], SIGMAS))
    for before, after in zip(registration.poses, reversed(again.poses), strict=True):
        assert after.station == before.station
        assert after.position_m == pytest.approx(before.position_m, abs=1e-6)


def test_same_scans_give_the_same_poses_to_the_last_bit(site: Site, registration: Registration) -> None:
    again = succeed(register_stations(site.scans, SIGMAS))
    assert np.array_equal(again.covariance, registration.covariance)
    assert all(
        np.array_equal(a.rotation, b.rotation) for a, b in zip(again.poses, registration.poses, strict=True)
    )


def test_a_heading_that_nothing_corrects_leaves_its_station_out(site: Site) -> None:
    heading = site.scans[1].heading_rad
    assert heading is not None
    wrong = replace(site.scans[1], heading_rad=heading + np.radians(20.0))
    registration = succeed(register_stations((site.scans[0], wrong, *site.scans[2:]), SIGMAS))
    (refused,) = registration.refused
    assert refused.station == wrong.station
    assert (
        "of its planes match any other station, needed 5 %; left out; check scan, heading_deg"
        in refused.reason
    )
    assert [diagnosis.state for diagnosis in registration.diagnoses] == ["ok"] * 4


def test_a_scan_without_any_plane_is_left_out_and_the_others_are_ok(yard: Courtyard) -> None:
    fog = np.random.default_rng(8).uniform(-100.0, 100.0, (20_000, 3))
    registration = succeed(register_stations(yard.with_scan(1, replace(yard.scans[1], points_m=fog)), SIGMAS))
    assert [refused.station for refused in registration.refused] == ["ST02"]
    assert registration.refused[0].reason.startswith("its scan holds 0 planes, needed 50; left out")
    assert [diagnosis.state for diagnosis in registration.diagnoses] == ["ok"] * 3


def test_a_scan_of_three_points_among_three_stations_is_refused_with_the_reason(yard: Courtyard) -> None:
    few = replace(yard.scans[1], points_m=yard.scans[1].points_m[:3])
    registration = succeed(register_stations(yard.with_scan(1, few)[:3], SIGMAS))
    (refused,) = registration.refused
    assert refused.station == "ST02"
    assert refused.reason == (
        "its scan holds 0 planes, needed 50; left out; scan denser, or check whether the file is in metres"
    )
    assert [diagnosis.state for diagnosis in registration.diagnoses] == ["ok"] * 2


def test_an_epoch_of_which_no_station_can_be_placed_fails_with_every_reason(yard: Courtyard) -> None:
    nowhere = [replace(scan, position_m=None) for scan in yard.scans[:2]]
    failure = register_stations(nowhere, SIGMAS, HINT)
    assert isinstance(failure, FitFailure)
    assert "station ST01: no position is stated" in failure.reason
    assert "station ST02: no position is stated" in failure.reason


def test_a_lone_station_keeps_the_pose_that_is_stated(site: Site) -> None:
    alone = succeed(register_stations(site.scans[:1], SIGMAS))
    assert alone.poses[0].position_m == pytest.approx(site.scans[0].position_m, abs=1e-12)
    assert alone.diagnoses[0].overlap is None
    assert np.sqrt(np.diag(alone.covariance)) == pytest.approx(
        [SIGMAS.level_rad] * 2 + [SIGMAS.heading_rad, 0.015, 0.015, 0.0225]
    )


def test_scans_that_share_nothing_stay_at_their_priors_and_say_so(site: Site) -> None:
    assert site.scans[1].position_m is not None
    far = replace(site.scans[1], position_m=site.scans[1].position_m + 5000.0)
    registration = succeed(register_stations((site.scans[0], far), SIGMAS))
    assert [d.state for d in registration.diagnoses] == ["suspect", "suspect"]
    assert all(
        d.reason is not None and "0 % of its planes match any other station" in d.reason
        for d in registration.diagnoses
    )
    assert all(d.weakest_direction is None for d in registration.diagnoses)


def test_stated_sigmas_of_poses_are_those_of_their_errors(yard: Courtyard) -> None:
    registration = succeed(register_stations(yard.scans, SIGMAS))
    errors = np.array(
        [p.position_m - q.position_m for p, q in zip(registration.poses, yard.truth, strict=True)]
    )
    sigmas = np.sqrt(np.diag(registration.covariance)).reshape(-1, 6)[:, 3:]
    # four stations that share one error of the frame: three numbers, hardly more
    assert np.abs(errors / sigmas).max() < 3.5


def test_a_registered_cloud_is_taken_as_it_is_but_not_better_than_its_level() -> None:
    registration = registered_cloud("registered", SIGMAS)
    points = np.array([[1.0, 2.0, 3.0]])
    assert registration.poses[0].to_site(points) == pytest.approx(points)
    assert np.sqrt(registration.covariance[0, 0]) == pytest.approx(SIGMAS.level_rad)


def test_an_epoch_without_scans_is_refused() -> None:
    with pytest.raises(ShapeError, match="at least one scan; got none"):
        register_stations([], SIGMAS)


def test_rotation_vectors_turn_by_their_length() -> None:
    rotation = rotation_from_vector(np.array([0.0, 0.0, np.pi / 2]))
    assert rotation @ np.array([1.0, 0.0, 0.0]) == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)


@pytest.mark.slow
def test_headings_that_nobody_stated_come_out_as_if_they_had_been_stated(eight: SeenSite) -> None:
    scans: list[StationScan] = [replace(scan, heading_rad=None) for scan in eight.scans]
    registration = succeed(register_stations(scans, SIGMAS, HINT))
    assert [diagnosis.state for diagnosis in registration.diagnoses] == ["ok"] * 8
    # eight GNSS positions of 15 mm at 250 m
    assert np.sqrt(np.mean(heading_errors_arcsec(eight, registration) ** 2)) < 30


@pytest.mark.slow
def test_swapped_stations_are_adjusted_where_they_stood(eight: SeenSite) -> None:
    scans = list(eight.scans)
    scans[1] = replace(eight.scans[1], points_m=eight.scans[3].points_m)
    scans[3] = replace(eight.scans[3], points_m=eight.scans[1].points_m)
    registration = succeed(register_stations(scans, SIGMAS, HINT))
    states = ["suspect" if i in {1, 3} else "ok" for i in range(8)]
    assert [diagnosis.state for diagnosis in registration.diagnoses] == states
    for i, other in ((1, 3), (3, 1)):
        assert registration.poses[i].position_m == pytest.approx(
            eight.stations[other].setup.position_m, abs=0.05
        )


@pytest.mark.slow
@pytest.mark.parametrize(("off_m", "part"), [((0.3, -0.4, 0.0), "position"), ((0.0, 0.0, 0.5), "height")])
def test_a_blunder_of_half_a_metre_is_named_on_a_site_and_put_right(
    eight: SeenSite, off_m: tuple[float, float, float], part: str
) -> None:
    scans = list(eight.scans)
    assert scans[2].position_m is not None
    scans[2] = replace(scans[2], position_m=scans[2].position_m + np.array(off_m))
    registration = succeed(register_stations(scans, SIGMAS, HINT))
    assert [d.state for d in registration.diagnoses] == ["suspect" if i == 2 else "ok" for i in range(8)]
    reason = registration.diagnoses[2].reason
    assert reason is not None
    assert reason.startswith(f"stated {part} is 0.5")
    assert registration.poses[2].position_m == pytest.approx(eight.stations[2].setup.position_m, abs=0.05)
