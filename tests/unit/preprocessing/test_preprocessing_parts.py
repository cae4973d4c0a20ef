"""Laws of the parts: bands, circles by consensus, lone points, duplicates."""

import numpy as np
import pytest

from tasks.preprocessing.bands import sample_bands, split_bands
from tasks.preprocessing.consensus import CircleSearch, find_circles
from tasks.preprocessing.denoising import find_isolated
from tasks.preprocessing.redundancy import find_duplicates
from tasks.preprocessing.surface import TERMS, Surface, _look, distance_from, unroll

EDGES_M = np.linspace(0.0, 10.0, 6)
SEARCH = CircleSearch((0.7, 1.4), 0.03)


def arc(rng: np.random.Generator, n: int, span_rad: float) -> np.ndarray:
    angle = rng.uniform(0.0, span_rad, n)
    radius = 1.0 + rng.normal(0.0, 0.005, n)
    return np.column_stack([3.0 + radius * np.cos(angle), 4.0 + radius * np.sin(angle)])


def every(points: np.ndarray) -> np.ndarray:
    return np.ones(len(points), dtype=np.bool_)


def test_every_point_falls_in_one_band() -> None:
    rows = np.concatenate(split_bands(np.random.default_rng(1).uniform(0.0, 10.0, 1_000), EDGES_M))
    assert np.array_equal(np.sort(rows), np.arange(1_000))


def test_bands_hold_the_heights_between_their_edges() -> None:
    z = np.random.default_rng(1).uniform(0.0, 10.0, 1_000)
    assert [int(z[rows].max() // 2.0) for rows in split_bands(z, EDGES_M)] == [0, 1, 2, 3, 4]


def test_a_sample_draws_no_point_twice() -> None:
    rng = np.random.default_rng(2)
    rows = np.concatenate(sample_bands(rng.uniform(0.0, 10.0, 1_000), EDGES_M, 50, rng))
    assert len(np.unique(rows)) == len(rows) == 250


def test_the_circle_of_an_arc_is_found_among_as_many_strays() -> None:
    rng = np.random.default_rng(3)
    xy = np.vstack([arc(rng, 300, np.pi), rng.uniform([1.0, 2.0], [5.0, 6.0], (300, 2))])
    # strays inside cost the arc its score, so only the place is asked; 5 mm noise, 300 points of half an arc
    assert find_circles(xy, SEARCH, rng).parameters_m[0] == pytest.approx([3.0, 4.0, 1.0], abs=0.02)


def test_a_dense_patch_does_not_outvote_the_round() -> None:
    rng = np.random.default_rng(4)
    patch = rng.normal([5.5, 4.0], 0.15, (2_000, 2))
    assert find_circles(np.vstack([arc(rng, 400, 2 * np.pi), patch]), SEARCH, rng).parameters_m[
        0
    ] == pytest.approx([3.0, 4.0, 1.0], abs=0.02)


def test_a_ring_around_the_shaft_loses_to_the_shaft() -> None:
    rng = np.random.default_rng(11)
    ring = (3.0, 4.0) + 1.35 * (arc(rng, 1_500, 2 * np.pi) - (3.0, 4.0))
    best = find_circles(np.vstack([arc(rng, 400, 2 * np.pi), ring]), SEARCH, rng).parameters_m[0]
    assert best == pytest.approx([3.0, 4.0, 1.0], abs=0.02)


def test_the_score_of_a_full_clean_circle_is_one() -> None:
    rng = np.random.default_rng(5)
    assert find_circles(arc(rng, 800, 2 * np.pi), SEARCH, rng).scores[0] == pytest.approx(1.0)


def test_points_on_a_line_give_no_circle() -> None:
    xy = np.column_stack([np.arange(50.0), np.arange(50.0)])
    assert len(find_circles(xy, SEARCH, np.random.default_rng(6)).scores) == 0


def test_a_lone_point_is_isolated_and_its_crowd_is_not() -> None:
    rng = np.random.default_rng(7)
    around = np.append(rng.uniform(0.0, 3.0, 2_000), 9.0)
    up = np.append(rng.uniform(0.0, 10.0, 2_000), 5.0)
    assert np.flatnonzero(find_isolated(around, up, EDGES_M, 3)).tolist() == [2_000]


def test_a_sparse_end_is_not_isolated() -> None:
    rng = np.random.default_rng(8)
    up = np.concatenate([rng.uniform(0.0, 2.0, 20_000), rng.uniform(2.0, 10.0, 400)])
    assert not find_isolated(rng.uniform(0.0, 10.0, len(up)), up, EDGES_M, 3).any()


def test_no_points_hold_no_isolated_one() -> None:
    assert len(find_isolated(np.empty(0), np.empty(0), EDGES_M, 3)) == 0


def test_the_first_point_of_a_voxel_stays() -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.011, 0.0, 0.0], [0.004, 0.001, 0.0], [0.0, 0.0, 0.012]])
    assert find_duplicates(points, every(points), 0.005).tolist() == [
        False,
        False,
        True,
        False,
    ]


@pytest.mark.parametrize("spread_m", [1.0, 1e7])
def test_packed_and_plain_keys_choose_the_same_points(spread_m: float) -> None:
    # the wide cloud does not fit into packed keys; both hold each of 500 points four times
    rng = np.random.default_rng(9)
    points = np.tile(rng.uniform(0.0, spread_m, (500, 3)), (4, 1))
    assert np.flatnonzero(~find_duplicates(points, every(points), 1e-4)).tolist() == list(range(500))


@pytest.mark.parametrize("voxel_m", [0.003, 0.05, 0.4])
def test_the_first_points_of_cubes_are_those_of_a_plain_search(voxel_m: float) -> None:
    # more points than one layer holds
    points = np.random.default_rng(11).uniform(-3.0, 5.0, (1_100_000, 3))
    cubes = np.floor((points - points.min(axis=0)) / voxel_m).astype(np.int64)
    sides = cubes.max(axis=0) + 1
    key = (cubes[:, 2] * sides[1] + cubes[:, 1]) * sides[0] + cubes[:, 0]
    plain = np.sort(np.unique(key, return_index=True)[1])
    assert np.array_equal(np.flatnonzero(~find_duplicates(points, every(points), voxel_m)), plain)


def test_points_that_do_not_count_make_no_duplicate() -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.001, 0.0, 0.0], [0.002, 0.0, 0.0], [0.0, 0.0, 1.0]])
    among = np.array([False, True, True, True])
    assert find_duplicates(points, among, 0.005).tolist() == [False, False, True, False]
    assert not find_duplicates(points, np.zeros(4, dtype=np.bool_), 0.005).any()


def test_duplicates_among_some_are_those_of_these_alone() -> None:
    rng = np.random.default_rng(13)
    points, among = rng.uniform(0.0, 3.0, (1_200_000, 3)), rng.random(1_200_000) < 0.9
    alone = find_duplicates(points[among], every(points[among]), 0.02)
    assert np.array_equal(find_duplicates(points, among, 0.02)[among], alone)
    assert 0.1 < alone.mean() < 0.9


def test_compiled_places_are_those_of_the_fit() -> None:
    rng = np.random.default_rng(12)
    knots_m = np.linspace(2.0, 42.0, 9)
    values_m = 0.05 * rng.standard_normal((9, TERMS))
    values_m[:, 2] += 3.0
    surface = Surface(knots_m, values_m, 0.003)
    points = np.column_stack([rng.uniform(-4.0, 4.0, (20_000, 2)), rng.uniform(0.0, 44.0, 20_000)])
    away, look = distance_from(surface, points), _look(surface, points)
    assert away.off_m == pytest.approx(look.residual_m, abs=1e-12)
    assert away.radius_m == pytest.approx(look.radius_m, rel=1e-14)
    arc_m = np.arctan2(look.terms[:, 1], look.terms[:, 0]) * look.radius_m
    assert unroll(surface, points) == pytest.approx(arc_m, abs=1e-12)


def test_what_was_thinned_has_no_duplicates_left() -> None:
    points = np.random.default_rng(10).uniform(0.0, 0.1, (5_000, 3))
    kept = np.vstack([[0.0, 0.0, 0.0], points])  # the corner that fixes the cubes stays first
    kept = kept[~find_duplicates(kept, every(kept), 0.01)]
    assert not find_duplicates(kept, every(kept), 0.01).any()
