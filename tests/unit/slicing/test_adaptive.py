"""Slices that follow the points: just thick enough for the wanted sigma of a centre."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.slicing import (
    AdaptiveCut,
    AdaptiveSlices,
    RingPoints,
    ThicknessLimit,
    adaptive_slices,
    cut_between,
    linear_limit,
)
from tasks.slicing.center_information import center_variances, sum_layers

SHAFT_M = (2.0, 102.0)
STRAIGHT = ThicknessLimit(np.array(SHAFT_M), np.array([np.inf]))
NOISE_M = 0.01


def ring(z_m: NDArray[np.float64], half_arc_rad: float = np.pi, seed: int = 4) -> RingPoints:
    """Points at these heights, all around or on an arc, of one noise."""
    azimuth = np.random.default_rng(seed).uniform(-half_arc_rad, half_arc_rad, len(z_m))
    return RingPoints(z_m, azimuth, np.full(len(z_m), NOISE_M))


def dense(n: int) -> NDArray[np.float64]:
    return np.linspace(*SHAFT_M, n)


def variance_of(points: RingPoints) -> float:
    sums = sum_layers([points], np.linspace(*SHAFT_M, 11))
    return float(center_variances(sums.between(np.array([0]), np.array([10])))[0])


def cut(points: RingPoints, sigma_m: float = 0.001, most_m: float = 2.0) -> AdaptiveSlices:
    return adaptive_slices([points], AdaptiveCut(sigma_m, 0.02, most_m), SHAFT_M, STRAIGHT)


# science: variance of the less certain component in units of sigma^2 / N, by arc
@pytest.mark.parametrize(
    ("arc_deg", "factor"), [(360, 2.0), (270, 3.29), (180, 10.6), (120, 43.8), (60, 623)]
)
def test_the_variance_of_a_centre_on_an_arc_is_that_of_the_bound(arc_deg: float, factor: float) -> None:
    n = 20_001
    azimuth = np.radians(np.linspace(-arc_deg / 2, arc_deg / 2, n))
    found = variance_of(RingPoints(dense(n), azimuth, np.full(n, NOISE_M)))
    assert found == pytest.approx(factor * NOISE_M**2 / n, rel=0.005)


@pytest.mark.parametrize("is_weighted", [True, False])
def test_the_variance_of_points_of_unequal_noise_is_that_of_the_fit_that_follows(is_weighted: bool) -> None:
    rng = np.random.default_rng(6)
    n = 400
    azimuth, sigma = rng.uniform(-1.5, 1.5, n), rng.uniform(0.002, 0.02, n)
    weights = sigma**-2 if is_weighted else np.ones(n)
    design = np.column_stack([np.cos(azimuth), np.sin(azimuth), np.ones(n)])
    gain = np.linalg.solve(design.T @ (weights[:, None] * design), design.T * weights)
    expected = np.linalg.eigvalsh(((gain * sigma**2) @ gain.T)[:2, :2])[-1]
    points = RingPoints(dense(n), azimuth, sigma, weights if is_weighted else None)
    assert variance_of(points) == pytest.approx(expected, rel=1e-9)


def test_too_few_points_and_points_in_one_direction_fix_no_centre() -> None:
    assert variance_of(ring(dense(29))) == np.inf
    assert variance_of(ring(dense(30))) < np.inf
    assert variance_of(RingPoints(dense(500), np.full(500, 0.3), np.full(500, NOISE_M))) == np.inf


def test_slices_of_an_even_ring_are_as_thick_as_the_law_says() -> None:
    n = 100_000
    # 2 sigma^2 / (n h / L) = s^2
    thickness_m = 2.0 * NOISE_M**2 / 0.001**2 * 100.0 / n
    slices = cut(ring(dense(n)))
    assert np.mean(np.diff(slices.edges_m)) == pytest.approx(thickness_m, rel=0.1)
    assert slices.sigma_m[:-1] == pytest.approx(0.001, rel=0.05)


def test_half_the_sigma_needs_slices_four_times_as_thick() -> None:
    points = ring(dense(100_000))
    coarse, fine = (np.mean(np.diff(cut(points, s).edges_m)) for s in (0.002, 0.001))
    assert fine / coarse == pytest.approx(4.0, rel=0.1)


def test_slices_stand_on_one_another_and_hold_every_point_once() -> None:
    z_m = np.random.default_rng(2).uniform(*SHAFT_M, 50_000)
    slices = cut(ring(z_m))
    assert (slices.edges_m[0], slices.edges_m[-1]) == SHAFT_M
    assert (np.diff(slices.edges_m) > 0.0).all()
    held = np.concatenate(cut_between(z_m, slices.edges_m))
    assert sorted(held) == list(range(len(z_m)))


def test_where_points_are_dense_slices_are_thin() -> None:
    rng = np.random.default_rng(9)
    z_m = np.concatenate([rng.uniform(2.0, 52.0, 80_000), rng.uniform(52.0, 102.0, 20_000)])
    edges = cut(ring(z_m)).edges_m
    thickness, middles = np.diff(edges), (edges[1:] + edges[:-1]) / 2
    low, high = thickness[middles < 51.0].mean(), thickness[middles > 53.0].mean()
    assert high / low == pytest.approx(4.0, rel=0.1)


def test_what_even_the_thickest_slice_cannot_reach_stays_with_its_larger_sigma() -> None:
    rng = np.random.default_rng(9)
    z_m = np.concatenate([rng.uniform(2.0, 52.0, 80_000), rng.uniform(52.0, 102.0, 2_000)])
    slices = cut(ring(z_m))
    middles = (slices.edges_m[1:] + slices.edges_m[:-1]) / 2
    sparse = middles > 55.0
    assert np.diff(slices.edges_m)[sparse][:-2] == pytest.approx(2.0, abs=1e-9)
    # 80 points a slice: 10 mm sqrt(2 / 80), and a little for their uneven spread
    assert np.median(slices.sigma_m[sparse]) == pytest.approx(0.00158, rel=0.15)
    assert (slices.sigma_m[~sparse][:-1] <= 0.001).all()


def test_heights_without_points_are_slices_without_a_centre() -> None:
    z_m = dense(100_000)
    slices = cut(ring(z_m[(z_m < 40.0) | (z_m > 50.0)]))
    middles = (slices.edges_m[1:] + slices.edges_m[:-1]) / 2
    assert np.isinf(slices.sigma_m[(middles > 43.0) & (middles < 47.0)]).all()
    assert slices.sigma_m[middles < 39.0] == pytest.approx(0.001, rel=0.05)


@pytest.mark.parametrize("n", [31_000, 41_000, 53_000, 67_000])
def test_what_is_left_at_the_upper_end_joins_the_last_slice(n: int) -> None:
    slices = cut(ring(dense(n)))
    # at most twice the points that are wanted
    assert 0.001 / np.sqrt(2.0) * 0.95 < slices.sigma_m[-1] <= 0.001


def test_what_is_left_above_a_slice_of_greatest_thickness_shares_with_it() -> None:
    edges = cut(ring(dense(2_000)), most_m=3.0).edges_m
    assert np.diff(edges)[:-2] == pytest.approx(3.0, abs=1e-9)
    assert np.diff(edges)[-2:] == pytest.approx(2.0, abs=0.01)


def test_a_slice_is_no_thicker_than_the_bend_of_the_shaft_allows() -> None:
    limit = ThicknessLimit(np.array([2.0, 40.0, 60.0, 102.0]), np.array([np.inf, 0.3, np.inf]))
    edges = adaptive_slices([ring(dense(10_000))], AdaptiveCut(0.001), SHAFT_M, limit).edges_m
    bent = (edges[:-1] < 60.0) & (edges[1:] > 40.0)
    assert np.diff(edges)[bent].max() <= 0.3 + 1e-9
    assert np.diff(edges)[~bent].max() > 1.5


def test_a_shaft_below_the_least_thickness_has_no_slice() -> None:
    points = ring(np.linspace(5.0, 5.01, 100))
    assert adaptive_slices([points], AdaptiveCut(0.001), (5.0, 5.01), STRAIGHT).edges_m.size == 0
    assert cut_between(points.z_m, np.empty(0)) == []


def test_a_shaft_upside_down_is_misuse() -> None:
    with pytest.raises(ShapeError, match="lo < hi"):
        adaptive_slices([ring(dense(100))], AdaptiveCut(0.001), (5.0, 2.0), STRAIGHT)
    with pytest.raises(ShapeError, match="one length"):
        RingPoints(dense(3), np.zeros(2), np.zeros(3))


def test_a_slice_at_the_limit_of_a_curved_axis_is_off_by_a_quarter_of_the_sigma() -> None:
    knots = np.linspace(*SHAFT_M, 51)
    curvature = 2e-3
    form = np.vstack([curvature * (knots - 52.0) ** 2 / 2.0, np.zeros(51), np.full(51, 3.0)])
    thickness = linear_limit(knots, form, 0.002).at(np.array(52.0))
    rise = np.linspace(-0.5, 0.5, 100_001) * thickness
    # the middle is held by the other law: there the axis leans as the whole
    assert np.mean(curvature * rise**2 / 2.0) <= 0.25 * 0.002 * (1.0 + 1e-6)
    straight_lean = linear_limit(knots, form - form[:, [25]], 0.002)
    assert straight_lean.at(np.array(52.0)) == thickness


def test_a_slice_at_the_limit_of_a_bent_part_is_off_by_a_quarter_of_the_sigma() -> None:
    form = np.array([[0.0, 0.08, 0.0], [0.0, 0.06, 0.0], [3.0, 3.0, 3.0]])
    knots = np.array([0.0, 50.0, 100.0])
    thickness = linear_limit(knots, form, 0.002).at(np.array(20.0))
    # leans by 2e-3 off the whole; points of the upper half only rise by h / 4 on the mean
    assert thickness == pytest.approx(min(4.0 * 0.0005 / 2e-3, np.sqrt(24.0 * 0.0005 / (4e-3 / 50.0))))


def test_a_straight_cone_has_no_limit() -> None:
    knots = np.array([0.0, 50.0, 100.0])
    form = np.array([[0.0] * 3, [0.0] * 3, [4.0, 3.5, 3.0]])
    assert np.isinf(linear_limit(knots, form, 0.002).most_m).all()
