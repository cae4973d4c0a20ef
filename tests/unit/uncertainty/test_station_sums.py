"""Slices of a tapering, leaning shaft with a circle fit of its own: what poses and stations do to the lean."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.uncertainty import (
    Skin,
    base_leverage,
    changes_without_each,
    leverage,
    moved_by_poses,
    pose_jacobian,
    sum_by_station,
)

LEAN = np.array([0.02, -0.03])
TAPER = -0.019
STATIONS_M = np.array([[230.0, -13.0, 1.6], [-120.0, 210.0, 2.0], [-90.0, -240.0, 1.5]])
HEIGHTS_M = np.array([2.0, 14.0, 30.0, 47.0, 66.0, 80.0, 101.0])
WEIGHTS = np.array([1.0, 0.9, 0.3, 1.0, 0.7, 0.8, 0.6])


@dataclass(frozen=True)
class Cut:
    """Points of one slice and who saw them."""

    z_m: float
    points_m: NDArray[np.float64]
    station: NDArray[np.intp]

    def of_others(self, station: int) -> "Cut":
        """The slice without a station."""
        left = self.station != station
        return Cut(self.z_m, self.points_m[left], self.station[left])


def slices(noise_m: float = 0.0, seed: int = 1) -> list[Cut]:
    """Slices 20 cm thick; every station sees the 160 degrees that face it, the third one more thinly."""
    rng = np.random.default_rng(seed)
    cuts = []
    for z_m in HEIGHTS_M:
        parts, station = [], []
        for number, (place, count) in enumerate(zip(STATIONS_M, (150, 110, 60), strict=True)):
            turn = np.arctan2(place[1], place[0]) + rng.uniform(-1.4, 1.4, count)
            z = z_m + rng.uniform(-0.1, 0.1, count)
            radius = 4.6 + TAPER * z + noise_m * rng.standard_normal(count)
            xy = np.outer(z, LEAN) + radius[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
            parts.append(np.column_stack([xy, z]))
            station.append(np.full(count, number))
        cuts.append(Cut(float(z_m), np.concatenate(parts), np.concatenate(station)))
    return cuts


def distances(cut: Cut, circle: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Residuals (n,) of a slice from a circle (east, north, radius), and the horizontal rays (n, 2)."""
    rise = cut.points_m[:, 2] - cut.z_m
    ray = cut.points_m[:, :2] - circle[:2] - np.outer(rise, LEAN)
    return np.linalg.norm(ray, axis=1) - circle[2] - TAPER * rise, ray


def circle_of(cut: Cut) -> NDArray[np.float64]:
    """Circle (east, north, radius) of least squares of the distances from it."""
    circle = np.array([*(LEAN * cut.z_m), 4.6 + TAPER * cut.z_m])
    for _ in range(8):
        residual, ray = distances(cut, circle)
        terms = np.column_stack([ray / np.linalg.norm(ray, axis=1)[:, None], np.ones(len(ray))])
        circle = circle + np.linalg.lstsq(terms, residual, rcond=None)[0]
    return circle


def line_of(cuts: list[Cut], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weighted line (2, 2) through the centres: rows at z = 0 and lean."""
    centres = np.array([circle_of(cut)[:2] for cut in cuts])
    terms = np.column_stack([np.ones(len(cuts)), [cut.z_m for cut in cuts]])
    weighted = terms * weights[:, None]
    return np.asarray(np.linalg.solve(weighted.T @ terms, weighted.T @ centres))


def sums_of(cuts: list[Cut]) -> NDArray[np.float64]:
    found = []
    for cut in cuts:
        residual, ray = distances(cut, circle_of(cut))
        out = ray / np.linalg.norm(ray, axis=1)[:, None]
        outward = np.column_stack([out, -TAPER - out @ LEAN])
        found.append(sum_by_station(Skin(cut.points_m, outward, residual, cut.station), len(STATIONS_M)))
    return np.array(found)


def moved(cuts: list[Cut], station: int, pose: NDArray[np.float64]) -> list[Cut]:
    """The slices with the points of a station turned about it and shifted."""
    after = []
    for cut in cuts:
        points = cut.points_m.copy()
        own = cut.station == station
        points[own] += np.cross(pose[:3], points[own] - STATIONS_M[station]) + pose[3:]
        after.append(Cut(cut.z_m, points, cut.station))
    return after


@pytest.mark.parametrize("station", range(3))
@pytest.mark.parametrize("parameter", range(6))
def test_a_pose_moves_the_line_as_the_jacobian_says(station: int, parameter: int) -> None:
    cuts = slices()
    pose = np.zeros(6)
    pose[parameter] = 1e-6 if parameter < 3 else 1e-4
    sums = sums_of(cuts)
    found = line_of(moved(cuts, station, pose), WEIGHTS) - line_of(cuts, WEIGHTS)
    place = 6 * station + parameter
    lean = pose_jacobian(sums, HEIGHTS_M, WEIGHTS, STATIONS_M)[:, place] * pose[parameter]
    base = moved_by_poses(sums, base_leverage(HEIGHTS_M, WEIGHTS), STATIONS_M)[:, place] * pose[parameter]
    # second order of a shift of 0.1 mm on a radius of 4 m, and of 250 m times 1e-6
    assert found[1] == pytest.approx(lean, rel=1e-3, abs=1e-11)
    assert found[0] == pytest.approx(base, rel=1e-3, abs=1e-9)


def test_a_level_error_that_all_stations_share_leans_the_shaft_by_itself() -> None:
    jacobian = pose_jacobian(sums_of(slices()), HEIGHTS_M, WEIGHTS, STATIONS_M)
    about_east, about_north = (jacobian[:, part::6].sum(axis=1) for part in (0, 1))
    # a turn about east takes the plumb line south, one about north takes it east. Each station turns about itself: its
    # points rise by up to 240 m of the turn, the taper makes 4.6 m of it, and slices are not sampled quite alike
    assert about_east == pytest.approx([0.0, -1.0], abs=0.01)
    assert about_north == pytest.approx([1.0, 0.0], abs=0.01)


def test_a_shift_that_all_stations_share_leaves_the_lean() -> None:
    jacobian = pose_jacobian(sums_of(slices()), HEIGHTS_M, WEIGHTS, STATIONS_M)
    for part in (3, 4):
        assert jacobian[:, part::6].sum(axis=1) == pytest.approx([0.0, 0.0], abs=1e-10)


@pytest.mark.parametrize("station", range(3))
def test_a_station_that_is_left_out_changes_the_lean_as_a_fit_without_it(station: int) -> None:
    cuts = slices(noise_m=0.01)
    changes = changes_without_each(sums_of(cuts), HEIGHTS_M, WEIGHTS)
    assert changes is not None
    wanted = line_of([cut.of_others(station) for cut in cuts], WEIGHTS)[1] - line_of(cuts, WEIGHTS)[1]
    # second order: (1 cm)^2 on a radius of 4 m, a few per cent of what a station changes
    assert changes[station] == pytest.approx(wanted, abs=0.05 * float(np.abs(wanted).max()))


def test_a_slice_that_one_station_alone_sees_is_lost_with_it() -> None:
    cuts = slices(noise_m=0.01)
    cuts[-1] = cuts[-1].of_others(1).of_others(2)
    changes = changes_without_each(sums_of(cuts), HEIGHTS_M, WEIGHTS)
    assert changes is not None
    kept = [cut.of_others(0) for cut in cuts[:-1]]
    wanted = line_of(kept, WEIGHTS[:-1])[1] - line_of(cuts[:-1], WEIGHTS[:-1])[1]
    assert changes[0] == pytest.approx(wanted, abs=0.05 * float(np.abs(wanted).max()))


def test_nothing_is_said_of_stations_where_one_alone_sees_all_but_one_slice() -> None:
    cuts = slices()
    alone = [cut.of_others(1).of_others(2) for cut in cuts[1:]]
    assert changes_without_each(sums_of([cuts[0], *alone]), HEIGHTS_M, WEIGHTS) is None


def test_a_station_without_points_is_none_that_is_left_out() -> None:
    sums = sums_of(slices(noise_m=0.01))
    with_idle = np.insert(sums, 1, 0.0, axis=1)
    changes = changes_without_each(sums, HEIGHTS_M, WEIGHTS)
    assert changes is not None
    assert changes_without_each(with_idle, HEIGHTS_M, WEIGHTS) == pytest.approx(changes, rel=1e-12)


def test_slices_without_weight_do_not_change_the_lean() -> None:
    cuts = slices(noise_m=0.01)
    weights = WEIGHTS.copy()
    weights[3] = 0.0
    rest = [0, 1, 2, 4, 5, 6]
    assert changes_without_each(sums_of(cuts), HEIGHTS_M, weights) == pytest.approx(
        np.array(changes_without_each(sums_of(cuts)[rest], HEIGHTS_M[rest], weights[rest])), rel=1e-12
    )


def test_levers_turn_the_points_of_any_line_into_its_slope_and_its_foot() -> None:
    line_m = 3.0 + 0.25 * HEIGHTS_M
    assert leverage(HEIGHTS_M, WEIGHTS) @ line_m == pytest.approx(0.25, rel=1e-12)
    assert base_leverage(HEIGHTS_M, WEIGHTS) @ line_m == pytest.approx(3.0, rel=1e-12)


def test_a_skin_whose_arrays_disagree_is_misuse() -> None:
    with pytest.raises(ShapeError, match=r"of 5 points, got \(5, 2\), \(5,\) and \(5,\)"):
        sum_by_station(Skin(np.zeros((5, 3)), np.zeros((5, 2)), np.zeros(5), np.zeros(5, dtype=int)), 2)
