import numpy as np
import pytest
from scipy import stats

from storage.errors import ShapeError
from tasks.trend import LeanSeries, Outlook, Trend, fit_trend, limit_date
from tasks.trend.limit_date import merged, probability_inside
from tests.unit.trend.known_series import LINE, drawn, irregular_times


def outlook(
    movement: tuple[float, float],
    rate: tuple[float, float],
    sigma_m: float,
    sigma_rate: float,
    walk: float = 0.0,
) -> Outlook:
    covariance = np.diag([sigma_m**2] * 2 + [sigma_rate**2] * 2)
    return Outlook(
        np.ones(1), np.array([[*movement, *rate]]), covariance[None], np.array([walk]), np.zeros((2, 2))
    )


def test_probability_inside_a_circle_is_that_of_the_noncentral_chi_square() -> None:
    for mean, sigma, radius in [(0.0, 1.0, 2.0), (3.0, 1.0, 2.5), (100.0, 1.0, 101.0), (0.5, 2.0, 0.1)]:
        ours = probability_inside(np.array(radius), np.array([0.0, mean]), sigma**2 * np.eye(2))
        expected = stats.ncx2.cdf((radius / sigma) ** 2, 2, max((mean / sigma) ** 2, 1e-12))
        assert float(ours) == pytest.approx(expected, abs=1e-6)


def test_probability_inside_a_circle_holds_for_correlated_components() -> None:
    C = np.array([[2.0, 1.1], [1.1, 0.9]])
    rng = np.random.default_rng(1)
    points = np.array([0.7, -1.2]) + rng.standard_normal((400_000, 2)) @ np.linalg.cholesky(C).T
    share = np.mean(np.hypot(*points.T) < 1.5)
    assert float(probability_inside(np.array(1.5), np.array([0.7, -1.2]), C)) == pytest.approx(
        share, abs=0.003
    )


def test_far_from_zero_the_dates_are_those_of_one_component() -> None:
    """Movement 0.3 m, 10 mm a year to 0.4 m, sigma 2 mm at the last epoch and 1 mm a year of the rate."""
    found = limit_date(outlook((0.3, 0.0), (0.01, 0.0), 0.002, 0.001), 0.4)

    def bound(years: float, side: float) -> float:
        return 0.3 + 0.01 * years + side * 1.6449 * np.hypot(0.002, 0.001 * years)

    assert found.expected == pytest.approx(10.0, rel=1e-3)
    # what it may have moved sideways by then, 16 mm, makes the vector longer by up to 0.3 mm
    assert bound(found.earliest or 0.0, +1.0) == pytest.approx(0.4, abs=3e-4)
    assert bound(found.latest or 0.0, -1.0) == pytest.approx(0.4, abs=3e-4)


def test_direction_of_the_movement_counts_and_not_its_size_alone() -> None:
    """What leans east and moves west first comes upright; what moves north goes round."""
    west = limit_date(outlook((0.1, 0.0), (-0.01, 0.0), 1e-5, 1e-6), 0.15)
    north = limit_date(outlook((0.09, 0.0), (0.0, 0.01), 1e-5, 1e-6), 0.15)
    assert west.expected == pytest.approx(25.0, rel=1e-3)
    assert north.expected == pytest.approx(12.0, rel=1e-3)


def test_a_deviation_above_its_limit_is_reached_at_the_last_epoch() -> None:
    found = limit_date(outlook((0.3, 0.4), (0.0, 0.001), 0.001, 0.001), 0.4)
    assert (found.expected, found.earliest, found.latest) == (0.0, 0.0, 0.0)
    assert "already at the last epoch" in found.reason


def test_nothing_is_said_beyond_a_hundred_years() -> None:
    found = limit_date(outlook((0.1, 0.0), (0.0005, 0.0), 0.001, 1e-5), 0.4)
    assert (found.expected, found.earliest, found.latest) == (None, None, None)
    assert found.reason == "not within 100 years at this rate"


def test_a_random_walk_ahead_only_widens_the_band() -> None:
    without = limit_date(outlook((0.3, 0.0), (0.01, 0.0), 0.002, 0.001), 0.4)
    with_walk = limit_date(outlook((0.3, 0.0), (0.01, 0.0), 0.002, 0.001, walk=0.005), 0.4)
    assert with_walk.expected == without.expected
    assert (with_walk.earliest or 0.0) < (without.earliest or 0.0)
    assert (with_walk.latest or 0.0) > (without.latest or 0.0)


def test_a_limit_of_zero_is_refused() -> None:
    with pytest.raises(ShapeError, match="above 0 m"):
        limit_date(outlook((0.1, 0.0), (0.0, 0.0), 0.001, 0.001), 0.0)


def test_merged_outlook_keeps_mean_and_covariance() -> None:
    rng = np.random.default_rng(2)
    A = rng.standard_normal((300, 4, 4))
    weights = rng.uniform(size=300)
    many = Outlook(
        weights / weights.sum(),
        rng.standard_normal((300, 4)),
        A @ A.transpose(0, 2, 1),
        rng.uniform(size=300),
        np.zeros((2, 2)),
    )
    few = merged(many)
    assert len(few.weights) <= 24
    for before, after in ((many.rate, few.rate), (many.movement, few.movement)):
        np.testing.assert_allclose(after.value, before.value, atol=1e-12)
        np.testing.assert_allclose(after.covariance, before.covariance, rtol=1e-10)


@pytest.mark.parametrize(
    ("start", "rate", "limit_m", "sigma_m"),
    [
        ((0.2, 0.1), (0.004, 0.002), 0.4, 0.002),  # a lean far above its sigma
        ((0.0, 0.0), (0.001, 0.0), 0.03, 0.002),  # none
        ((0.0, 0.0), (0.002, 0.0), 0.01, 0.004),  # limit at twice the sigma
    ],
)
def test_true_date_lies_between_the_bounds(
    start: tuple[float, float], rate: tuple[float, float], limit_m: float, sigma_m: float
) -> None:
    """Each bound errs in at most 5 of 100 cases; of 300 not more than odds of 1000 to 1 allow."""
    rng = np.random.default_rng(8)
    early, late = 0, 0
    for _ in range(300):
        times = irregular_times(rng, 10)
        true = np.array(start) + np.outer(times - times[-1], rate)
        series = drawn(rng, times, np.tile(sigma_m**2 * np.eye(2), (10, 1, 1)), true)
        found = limit_date(outlook_of(series), limit_m)
        ahead = np.linspace(0.0, 100.0, 20001)
        path = np.hypot(*(np.array(start)[:, None] + np.outer(rate, ahead)))
        reached = ahead[np.argmax(path >= limit_m)]
        early += found.earliest is None or found.earliest > reached + 0.01
        late += found.latest is not None and found.latest < reached - 0.01
    assert max(early, late) <= stats.binom.ppf(0.999, 300, 0.05)


def outlook_of(series: LeanSeries) -> Outlook:
    found = fit_trend(series, LINE)
    assert isinstance(found, Trend)
    return found.outlook
