import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from storage.errors import ShapeError
from tasks.trend import LeanSeries, average_run_length, control_chart, control_limit, recursive_residuals
from tests.unit.trend.known_series import dense_covariance, drawn, irregular_times, some_covariances


@pytest.mark.parametrize(
    ("limit", "shift", "published"),
    # science.md section 4: two-sided, k = 0.5; 167 and 455 within 5 %, the others to their last digit
    [
        (4.0, 0.0, 167.0),
        (5.0, 0.0, 455.0),
        (4.0, 1.0, 8.4),
        (4.0, 2.0, 3.3),
        (5.0, 1.0, 10.4),
        (5.0, 2.0, 4.0),
    ],
)
def test_run_lengths_are_the_published_ones(limit: float, shift: float, published: float) -> None:
    tolerance = 0.05 * published if shift == 0.0 else 0.06
    assert average_run_length(0.5, limit, shift) == pytest.approx(published, abs=tolerance)


def test_one_sided_run_length_of_the_textbooks_is_twice_the_two_sided_one() -> None:
    """335 and 931 for h = 4 and 5."""
    assert 2.0 * average_run_length(0.5, 4.0) == pytest.approx(335.0, abs=0.5)
    assert 2.0 * average_run_length(0.5, 5.0) == pytest.approx(931.0, abs=0.5)


def test_two_charts_signal_nearly_twice_as_often_as_one() -> None:
    assert average_run_length(0.5, 4.0, charts=2) == pytest.approx(167.7 / 2.0, rel=0.04)


@pytest.mark.parametrize("run_length", [167.0, 455.0])
def test_limits_of_the_record_hold_for_both_charts_together(run_length: float) -> None:
    limit = control_limit(run_length)
    assert average_run_length(0.5, limit, charts=2) == pytest.approx(run_length, rel=1e-4)
    assert average_run_length(0.5, limit) > 1.9 * run_length


def run_lengths(rng: np.random.Generator, limit: float, trials: int) -> NDArray[np.float64]:
    """Two two-sided charts of independent standard normal numbers, until one signals."""
    up, down, done, epoch = np.zeros((trials, 2)), np.zeros((trials, 2)), [], 0
    while len(up):
        epoch += 1
        z = rng.standard_normal(up.shape)
        up, down = np.maximum(0.0, up + z - 0.5), np.maximum(0.0, down - z - 0.5)
        signals = np.maximum(up, down).max(axis=1) >= limit
        done.append(np.full(np.count_nonzero(signals), float(epoch)))
        up, down = up[~signals], down[~signals]
    return np.concatenate(done)


@pytest.mark.parametrize("run_length", [167.0, 455.0])
def test_simulated_charts_signal_falsely_as_often_as_stated(run_length: float) -> None:
    found = run_lengths(np.random.default_rng(3), control_limit(run_length), 4000)
    assert found.mean() == pytest.approx(run_length, rel=0.05)


def test_limits_that_no_chart_has_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"limit of 0\.5 to 15"):
        control_limit(1.5)
    with pytest.raises(ShapeError, match="h > 0"):
        average_run_length(0.5, 0.0)


def some_series(n: int = 10) -> LeanSeries:
    rng = np.random.default_rng(4)
    return drawn(rng, irregular_times(rng, n), some_covariances(rng, n, 0.001))


def test_an_epoch_stands_against_the_weighted_mean_of_all_earlier_ones() -> None:
    series = some_series()
    i = 6
    X = np.tile(np.eye(2), (i, 1))
    V = dense_covariance(series, 0.0)[: 2 * i, : 2 * i]
    within = np.linalg.inv(X.T @ np.linalg.solve(V, X))
    mean = within @ X.T @ np.linalg.solve(V, series.movements[:i].reshape(-1))
    off = series.movements[i] - mean
    found = recursive_residuals(series)[i - 1]
    assert found @ found == pytest.approx(
        off @ np.linalg.solve(series.covariances[i] + within, off), rel=1e-10
    )


def test_first_epoch_carries_no_residual() -> None:
    assert control_chart(some_series(1)).standardised.shape == (0, 2)
    assert control_chart(some_series(10)).largest.shape == (9,)


def test_residuals_of_a_still_structure_are_independent_standard_normal_numbers() -> None:
    rng = np.random.default_rng(5)
    times, covariances = irregular_times(rng, 8), some_covariances(rng, 8, 0.001)
    found = np.array([recursive_residuals(drawn(rng, times, covariances)).reshape(-1) for _ in range(1500)])
    assert stats.kstest(found.reshape(-1), "norm").pvalue > 0.01
    # correlations of 1500 repeats scatter by 0.026; 91 of them stay below 4.5 times that
    assert np.abs(np.corrcoef(found.T) - np.eye(14)).max() < 0.12


def test_chart_follows_its_definition() -> None:
    chart = control_chart(some_series())
    up, down = 0.0, 0.0
    for i, z in enumerate(chart.standardised[:, 1]):
        up, down = max(0.0, up + z - 0.5), max(0.0, down - z - 0.5)
        assert (chart.up[i, 1], chart.down[i, 1]) == pytest.approx((up, down))


def test_what_all_epochs_share_does_not_enter_the_chart() -> None:
    series = some_series()
    leaning = LeanSeries(series.times, series.movements + np.array([1.0, 2.0]), series.covariances)
    np.testing.assert_allclose(
        control_chart(leaning).standardised, control_chart(series).standardised, atol=1e-9
    )


def test_a_step_of_three_sigmas_signals_within_a_few_epochs() -> None:
    rng = np.random.default_rng(6)
    times, covariances = irregular_times(rng, 24), np.tile(1e-6 * np.eye(2), (24, 1, 1))
    moved = np.where(np.arange(24) >= 12, 0.003, 0.0)[:, None] * [1.0, 0.0]
    largest = control_chart(drawn(rng, times, covariances, moved)).largest
    first = 1 + int(np.argmax(largest >= control_limit(455.0)))
    assert 12 < first <= 16
