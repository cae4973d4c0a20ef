from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.registration.adjustment import Adjusted, Gates, Network, adjust
from tasks.registration.pair_report import diagnose_pairs
from tasks.registration.pairs import Matches
from tasks.registration.planar import scan_planes
from tasks.registration.stated import stated_pose
from tasks.registration.station import PairDiagnosis
from tests.unit.registration.courtyard import CORNER, NOISE_M, SIGMAS, Courtyard

FALSE_M = np.array([0.012, -0.009, 0.0])


@pytest.fixture(scope="module")
def adjusted(yard: Courtyard) -> Adjusted:
    """The courtyard at its adjusted poses, the statements right."""
    planes = scan_planes([scan.points_m for scan in yard.scans])
    stated = tuple(stated_pose(scan, true, SIGMAS) for scan, true in zip(yard.scans, yard.truth, strict=True))
    return adjust(Network(tuple(planes), stated), [one.pose for one in stated], Gates(0.12, 0.0))


def test_partners_from_an_adjustment_before_change_nothing(yard: Courtyard) -> None:
    planes = scan_planes([scan.points_m for scan in yard.scans])
    stated = tuple(stated_pose(scan, true, SIGMAS) for scan, true in zip(yard.scans, yard.truth, strict=True))
    start, used = [one.pose for one in stated], Network(tuple(planes), stated)
    adjust(used, start, Gates(1.2, 1.2))
    assert len(used.partners) == len(used.links)
    again, anew = (
        adjust(used, start, Gates(0.12, 0.0)),
        adjust(Network(tuple(planes), stated), start, Gates(0.12, 0.0)),
    )
    assert again.iterations == anew.iterations
    assert np.array_equal(again.data_matrix, anew.data_matrix)
    assert np.array_equal(again.poses[0].rotation, anew.poses[0].rotation)


def falsified(adjusted: Adjusted, i: int, j: int) -> Adjusted:
    """What the pair would see if the first stood aside against the second."""
    matches = dict(adjusted.matches)
    for layer in range(2):
        for link, sign in (((i, j, layer), 1.0), ((j, i, layer), -1.0)):
            found = matches[link]
            matches[link] = replace(
                found, residuals_m=found.residuals_m + sign * found.target.normals @ FALSE_M
            )
    return replace(adjusted, matches=matches)


def of_pair(pairs: tuple[PairDiagnosis, ...], station: str, other: str) -> PairDiagnosis:
    return next(pair for pair in pairs if (pair.station, pair.other) == (station, other))


def near_corner(found: Matches) -> NDArray[np.bool_]:
    away = np.hypot(*(found.source.points_m[:, :2] - np.array(CORNER.base_xy_m)).T)
    return np.asarray(away < max(CORNER.radius_m) + 2.0)


def test_every_ordered_pair_is_reported_once(adjusted: Adjusted) -> None:
    pairs = diagnose_pairs(adjusted, None)
    assert len({(pair.station, pair.other) for pair in pairs}) == len(pairs) == 12


def test_loops_of_a_good_epoch_close(adjusted: Adjusted) -> None:
    for pair in diagnose_pairs(adjusted, CORNER):
        assert pair.closure_m is not None
        assert pair.closure_rad is not None
        # planes of 3 mm noise, hundreds a pair, with all else stated the same
        assert pair.closure_m < 0.002
        assert pair.closure_rad < 1e-4


def test_a_falsified_pair_opens_its_loops_by_as_much_and_no_other(adjusted: Adjusted) -> None:
    pairs = diagnose_pairs(falsified(adjusted, 0, 1), None)
    size = float(np.linalg.norm(FALSE_M))
    for pair in pairs:
        assert pair.closure_m is not None
        # every pair of ST01 or ST02 shares a loop with the false one; ST03 and ST04 share none between them
        if {pair.station, pair.other} == {"ST03", "ST04"}:
            assert pair.closure_m < 0.002
        else:
            # a false pair is noisier and so weighs less against GNSS, which draws it back; loops close to 1.5 mm
            assert pair.closure_m == pytest.approx(size, abs=0.003)


def test_closures_of_both_directions_are_the_same(adjusted: Adjusted) -> None:
    pairs = diagnose_pairs(adjusted, None)
    for pair in pairs:
        assert pair.closure_m == of_pair(pairs, pair.other, pair.station).closure_m


def test_residuals_of_the_shaft_are_counted_apart_from_the_rest(adjusted: Adjusted) -> None:
    before = of_pair(diagnose_pairs(adjusted, CORNER), "ST01", "ST02")
    matches = dict(adjusted.matches)
    for layer in range(2):
        found = matches[0, 1, layer]
        doubled = np.where(near_corner(found), 2.0, 1.0) * found.residuals_m
        matches[0, 1, layer] = replace(found, residuals_m=doubled)
    after = of_pair(diagnose_pairs(replace(adjusted, matches=matches), CORNER), "ST01", "ST02")
    assert before.rmse_shaft_m is not None
    assert after.rmse_shaft_m == pytest.approx(2.0 * before.rmse_shaft_m, rel=1e-9)
    assert after.rmse_background_m == before.rmse_background_m


def test_without_a_hint_all_is_background(adjusted: Adjusted) -> None:
    for pair in diagnose_pairs(adjusted, None):
        assert pair.rmse_shaft_m is None
        assert pair.rmse_background_m == pair.rmse_m


def test_residuals_are_as_large_as_the_noise_of_point_and_plane(adjusted: Adjusted) -> None:
    for pair in diagnose_pairs(adjusted, None):
        assert pair.rmse_m is not None
        # one point against one point that stands for a plane: sqrt(2) of the noise of one
        assert pair.rmse_m == pytest.approx(np.sqrt(2.0) * NOISE_M, rel=0.25)


def test_two_stations_close_no_loop(adjusted: Adjusted) -> None:
    two = replace(
        adjusted,
        poses=adjusted.poses[:2],
        matches={link: found for link, found in adjusted.matches.items() if max(link[:2]) < 2},
    )
    assert [pair.closure_m for pair in diagnose_pairs(two, None)] == [None, None]


def test_overlap_is_the_share_of_planes_that_match(adjusted: Adjusted) -> None:
    pair = of_pair(diagnose_pairs(adjusted, None), "ST01", "ST02")
    both = [adjusted.matches[0, 1, layer] for layer in range(2)]
    assert pair.n_matches == sum(len(found.residuals_m) for found in both)
    assert pair.overlap == pytest.approx(pair.n_matches / sum(found.n_queries for found in both))
    assert 0.2 < pair.overlap <= 1.0
