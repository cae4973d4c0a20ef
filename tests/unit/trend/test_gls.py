"""The trend against an independent least squares, against laws, and against what series of known truth do."""

import numpy as np
import pytest
import statsmodels.api as sm
from scipy import stats

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.trend import LeanSeries, Terms, Trend, design_columns, fit_trend, gls_at
from tasks.trend.gls import state_covariance
from tasks.trend.walk import build_model, log_likelihood, rotate
from tests.unit.trend.known_series import (
    LINE,
    LINE_AND_WALK,
    dense_covariance,
    drawn,
    irregular_times,
    some_covariances,
)

ALL_TERMS = Terms(rate=True, season=True, temperature=False, random_walk=True, reason="")


def trend_of(series: LeanSeries, terms: Terms | None = None) -> Trend:
    found = fit_trend(series, terms)
    assert isinstance(found, Trend), found
    return found


def some_series(seed: int = 3, n: int = 14, walk: float = 0.001) -> LeanSeries:
    rng = np.random.default_rng(seed)
    times = irregular_times(rng, n)
    return drawn(rng, times, some_covariances(rng, n, 0.001), np.outer(times, [0.002, -0.001]), walk)


@pytest.mark.parametrize("walk", [0.0, 0.0004, 0.02])
def test_estimate_equals_generalised_least_squares_of_statsmodels(walk: float) -> None:
    series = some_series()
    columns = design_columns(series, ALL_TERMS)
    ours = gls_at(series, columns, walk)
    model = sm.GLS(
        series.movements.reshape(-1), np.kron(columns, np.eye(2)), sigma=dense_covariance(series, walk)
    )
    theirs = model.fit(cov_type="fixed scale")
    np.testing.assert_allclose(
        ours.values, theirs.params, rtol=1e-10, atol=1e-10 * np.abs(theirs.params).max()
    )
    np.testing.assert_allclose(
        ours.covariance, theirs.cov_params(), rtol=1e-9, atol=1e-10 * ours.covariance.max()
    )


def test_restricted_likelihood_is_that_of_the_dense_formula() -> None:
    series = some_series()
    X = np.kron(design_columns(series, ALL_TERMS), np.eye(2))
    model = build_model(series, design_columns(series, ALL_TERMS), True)
    y = series.movements.reshape(-1)
    sigmas = np.array([0.0, 0.001, 0.01])

    def dense(walk: float) -> float:
        V = dense_covariance(series, walk)
        W = np.linalg.inv(V)
        P = W - W @ X @ np.linalg.solve(X.T @ W @ X, X.T @ W)
        return -0.5 * (np.linalg.slogdet(V)[1] + np.linalg.slogdet(X.T @ W @ X)[1] + y @ P @ y)

    ours = log_likelihood(model.spectrum, rotate(model, y).left, sigmas)
    expected = np.array([dense(walk) for walk in sigmas])
    np.testing.assert_allclose(ours - ours[0], expected - expected[0], rtol=1e-8)


def test_state_at_the_end_is_the_best_prediction_with_its_covariance() -> None:
    """Against the posterior of level, rate and walk under a prior so wide that it says nothing."""
    series, walk, wide = some_series(), 0.0013, 1e2
    X = np.kron(design_columns(series, LINE_AND_WALK), np.eye(2))
    elapsed = np.kron((series.times - series.times[0])[:, None], np.eye(2))
    prior = np.diag([wide] * 4 + [walk**2 * series.span] * 2)
    across = np.vstack([wide * X.T, walk**2 * elapsed.T])
    V = dense_covariance(series, walk) + wide * X @ X.T
    posterior = prior - across @ np.linalg.solve(V, across.T)
    mean = across @ np.linalg.solve(V, series.movements.reshape(-1))
    F = np.hstack([np.eye(4), np.vstack([np.eye(2), np.zeros((2, 2))])])
    ours = gls_at(series, design_columns(series, LINE_AND_WALK), walk)
    np.testing.assert_allclose(ours.values[:4], F @ mean, atol=2e-7)
    np.testing.assert_allclose(
        state_covariance(ours.covariance[:4, :4], series.span, walk), F @ posterior @ F.T, atol=2e-10
    )


def test_a_turned_frame_turns_the_rate() -> None:
    series = some_series()
    angle = 0.7
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = LeanSeries(series.times, series.movements @ R.T, R @ series.covariances @ R.T)
    before, after = trend_of(series), trend_of(turned)
    np.testing.assert_allclose(after.rate.value, R @ before.rate.value, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(after.rate.covariance, R @ before.rate.covariance @ R.T, rtol=1e-5, atol=1e-12)
    assert after.rate_p_value == pytest.approx(before.rate_p_value, rel=1e-5)
    assert after.random_walk == pytest.approx(before.random_walk, rel=1e-4)


def test_other_units_of_length_change_nothing_but_the_unit() -> None:
    series = some_series()
    longer = LeanSeries(series.times, 1000.0 * series.movements, 1e6 * series.covariances)
    before, after = trend_of(series), trend_of(longer)
    np.testing.assert_allclose(after.rate.value, 1000.0 * before.rate.value, rtol=1e-9)
    assert after.rate.sigma == pytest.approx(1000.0 * before.rate.sigma, rel=1e-9)
    assert after.rate_p_value == pytest.approx(before.rate_p_value, rel=1e-6)


def test_a_lean_common_to_all_epochs_changes_no_rate() -> None:
    series = some_series()
    leaning = LeanSeries(
        series.times, series.movements + np.array([1.0, -0.4]), series.covariances, common=1e-4 * np.eye(2)
    )
    before, after = trend_of(series), trend_of(leaning)
    np.testing.assert_allclose(after.rate.value, before.rate.value, atol=1e-12)
    np.testing.assert_allclose(after.rate.covariance, before.rate.covariance, rtol=1e-6)
    np.testing.assert_allclose(
        after.outlook.movement.covariance - before.outlook.movement.covariance, 1e-4 * np.eye(2), atol=1e-12
    )


def test_noise_free_terms_are_found_exactly() -> None:
    times = np.arange(24) / 5.0
    temperatures = np.random.default_rng(2).uniform(-5.0, 25.0, 24)
    swing = np.outer(np.cos(2 * np.pi * times), [0.003, 0.0]) + np.outer(
        np.sin(2 * np.pi * times), [0.0, 0.001]
    )
    moved = (
        np.array([0.3, 0.1])
        + np.outer(times, [0.004, 0.003])
        + swing
        + np.outer(temperatures, [0.0003, 0.0004])
    )
    found = trend_of(LeanSeries(times, moved, np.tile(1e-8 * np.eye(2), (24, 1, 1)), temperatures))
    np.testing.assert_allclose(found.rate.value, [0.004, 0.003], atol=1e-9)
    assert found.rate.size == pytest.approx(0.005, rel=1e-6)
    assert found.season is not None
    assert found.season.value == pytest.approx(0.003, rel=1e-6)
    assert found.temperature is not None
    assert found.temperature.value == pytest.approx(0.0005, rel=1e-6)
    assert found.random_walk == 0.0


def test_too_few_epochs_have_no_rate_and_a_reason() -> None:
    rng = np.random.default_rng(1)
    found = fit_trend(drawn(rng, np.array([0.0, 1.0]), some_covariances(rng, 2, 0.001)))
    assert isinstance(found, FitFailure)
    assert found.reason == "no rate: 2 epochs over 1.00 years, needs 3"


def test_columns_that_repeat_each_other_are_refused() -> None:
    series = some_series()
    with pytest.raises(ShapeError, match="do not depend on each other"):
        gls_at(series, np.column_stack([np.ones(14), np.ones(14)]), 0.0)


def test_two_epochs_of_one_day_count_as_their_weighted_mean() -> None:
    series, walk = some_series(), 0.0013
    times = np.sort(np.concatenate([series.times[::2], series.times[::2]]))
    twice = LeanSeries(times, series.movements, series.covariances)
    weights = np.linalg.inv(series.covariances)
    whole = np.linalg.inv(weights[::2] + weights[1::2])
    pulls = np.einsum("nij,nj->ni", weights, series.movements)
    mean = LeanSeries(times[::2], np.einsum("nij,nj->ni", whole, pulls[::2] + pulls[1::2]), whole)
    each, merged = (gls_at(one, design_columns(one, LINE_AND_WALK), walk) for one in (twice, mean))
    np.testing.assert_allclose(each.values, merged.values, rtol=1e-9)
    np.testing.assert_allclose(each.covariance, merged.covariance, rtol=1e-8)


def repeats(walk: float, terms: Terms, trials: int, n: int = 12) -> list[tuple[LeanSeries, Trend]]:
    rng = np.random.default_rng(11)
    times, covariances = irregular_times(rng, n), some_covariances(rng, n, 0.001)
    every = [drawn(rng, times, covariances, np.outer(times, [0.001, 0.0]), walk) for _ in range(trials)]
    return [(series, trend_of(series, terms)) for series in every]


def test_stated_covariance_of_the_rate_matches_the_scatter_over_repeats() -> None:
    found = [trend for _, trend in repeats(0.0, LINE, 600)]
    scatter = np.cov(np.array([trend.rate.value for trend in found]).T)
    stated = found[0].rate.covariance
    # eigenvalues of a covariance from 600 repeats are known to 6 %
    assert np.linalg.eigvals(np.linalg.solve(stated, scatter)) == pytest.approx([1.0, 1.0], abs=0.2)


def test_misfit_is_uniform_if_the_stated_covariances_hold() -> None:
    p = [trend.misfit_p for _, trend in repeats(0.0, LINE, 400)]
    assert stats.kstest(p, "uniform").pvalue > 0.01


def test_understated_covariances_show_in_the_misfit() -> None:
    rng = np.random.default_rng(5)
    times, covariances = irregular_times(rng, 12), some_covariances(rng, 12, 0.003)
    series = drawn(rng, times, covariances)
    understated = LeanSeries(times, series.movements, covariances / 9.0)
    assert trend_of(understated, LINE).misfit_p < 1e-6


@pytest.mark.parametrize("walk", [0.0, 0.001, 0.002])
def test_rate_test_keeps_its_level_whatever_the_random_walk(walk: float) -> None:
    """Of 250 series without a rate at most as many fire as 5 % allow at odds of 1000 to 1."""
    rng = np.random.default_rng(6)
    times, covariances = irregular_times(rng, 16), some_covariances(rng, 16, 0.001)
    p = [trend_of(drawn(rng, times, covariances, walk=walk), LINE_AND_WALK).rate_p_value for _ in range(250)]
    assert np.count_nonzero(np.array(p) < 0.05) <= stats.binom.ppf(0.999, 250, 0.05)
    assert np.count_nonzero(np.array(p) < 0.01) <= stats.binom.ppf(0.999, 250, 0.01)


def test_a_random_walk_that_is_ignored_is_taken_for_a_rate() -> None:
    """What the walk in the model is for: without it far more than 20 % of the series fire at 5 %."""
    found = repeats(0.002, LINE, 100, n=16)
    shifted = [
        LeanSeries(one.times, one.movements - np.outer(one.times, [0.001, 0.0]), one.covariances)
        for one, _ in found
    ]
    p = np.array([trend_of(one, LINE).rate_p_value for one in shifted])
    assert np.mean(p < 0.05) > 0.2


def test_region_of_the_rate_holds_the_truth_under_a_random_walk() -> None:
    found = repeats(0.002, LINE_AND_WALK, 200, n=16)
    off = [trend.rate.value - [0.001, 0.0] for _, trend in found]
    inside = [
        o @ np.linalg.solve(trend.rate.covariance, o) < 5.991
        for o, (_, trend) in zip(off, found, strict=True)
    ]
    assert np.mean(inside) > 0.92


def test_random_walk_is_found_at_its_size() -> None:
    found = [trend.random_walk for _, trend in repeats(0.005, LINE_AND_WALK, 100, n=40)]
    assert np.mean(np.array(found)) == pytest.approx(0.005, rel=0.05)
