import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from storage.errors import ShapeError
from tasks.uncertainty import hotelling_factor, jackknife_covariance, state_covariance

STATION = np.array([[4.0, 1.0], [1.0, 2.0]]) * 1e-10
"""Covariance of the lean that one station alone would give."""


def leans(rng: np.random.Generator, n: int, worse: float = 1.0) -> NDArray[np.float64]:
    """What n independent stations find of a plumb axis, with errors that many times larger than ``STATION``."""
    return np.asarray(worse * rng.multivariate_normal(np.zeros(2), STATION, n))


def without_each(found: NDArray[np.float64]) -> NDArray[np.float64]:
    """Change of the mean with each station left out, by taking it out and averaging again."""
    rest = [np.delete(found, station, axis=0).mean(axis=0) for station in range(len(found))]
    return np.array(rest) - found.mean(axis=0)


def share_within(rng: np.random.Generator, n: int, worse: float) -> float:
    """Share of 400 draws in which the region of 95 % around the mean of the stations holds the truth."""
    hits = 0
    for _ in range(400):
        found = leans(rng, n, worse)
        stated = state_covariance(STATION / n, without_each(found)).covariance
        off = found.mean(axis=0)
        hits += int(off @ np.linalg.solve(stated, off) <= stats.chi2.ppf(0.95, 2))
    return hits / 400


def test_of_a_mean_the_jackknife_is_the_sample_covariance_over_n() -> None:
    found = leans(np.random.default_rng(1), 6)
    assert jackknife_covariance(without_each(found)) == pytest.approx(np.cov(found.T) / 6, rel=1e-10)


@pytest.mark.parametrize("n", [5, 8, 20])
def test_independent_station_errors_give_their_covariance_in_the_mean(n: int) -> None:
    rng = np.random.default_rng(2)
    draws = [jackknife_covariance(without_each(leans(rng, n))) for _ in range(800)]
    # of 3 degrees of freedom a variance is known to 82 %, over 800 draws to 2.9 %; 4 sd
    assert np.mean(draws, axis=0) == pytest.approx(STATION / n, abs=0.116 * STATION[0, 0] / n)


def test_stations_that_fit_keep_propagation_in_98_of_100() -> None:
    rng = np.random.default_rng(3)
    stated = [state_covariance(STATION / 8, without_each(leans(rng, 8))) for _ in range(1500)]
    kept = [s for s in stated if s.source == "propagation"]
    # sd of the share 0.56 %
    assert len(kept) / 1500 == pytest.approx(0.98, abs=0.015)
    assert all(s.covariance is not None and (s.covariance == STATION / 8).all() for s in kept)


def test_the_probability_of_the_misfit_is_uniform_where_stations_are_as_stated() -> None:
    rng = np.random.default_rng(4)
    found = [state_covariance(STATION / 5, without_each(leans(rng, 5))).misfit_p for _ in range(1500)]
    assert stats.kstest(np.array(found, float), "uniform").pvalue > 0.01


def test_stations_five_times_worse_than_stated_bring_the_larger_covariance() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        stated = state_covariance(STATION / 8, without_each(leans(rng, 8, 5.0)))
        assert stated.source == "jackknife"
        assert stated.misfit_p is not None
        assert stated.misfit_p < 1e-6
        assert np.trace(stated.covariance) > 5.0 * np.trace(STATION / 8)


def test_the_larger_covariance_is_so_in_every_direction() -> None:
    rng = np.random.default_rng(6)
    # stations that disagree in one direction only
    changes = without_each(leans(rng, 8) + np.outer(rng.normal(0, 2e-4, 8), [0.6, 0.8]))
    stated = state_covariance(STATION / 8, changes)
    assert stated.source == "jackknife"
    assert stated.jackknife is not None
    for part in (STATION / 8, stated.jackknife * hotelling_factor(8)):
        least = np.linalg.eigvalsh(stated.covariance - part)[0]
        assert least > -1e-6 * np.trace(stated.covariance)


def test_the_factor_for_few_stations_is_that_of_hotelling() -> None:
    # T^2 of two dimensions and 7 degrees of freedom is 2 * 7 / 6 times F(2, 6)
    wanted = 2.0 * 7.0 / 6.0 * stats.f.ppf(0.95, 2, 6) / stats.chi2.ppf(0.95, 2)
    assert hotelling_factor(8) == pytest.approx(wanted, rel=1e-9)
    assert hotelling_factor(10_000) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("n", [0, 2, 4])
def test_below_five_stations_propagation_stands_alone(n: int) -> None:
    stated = state_covariance(STATION, np.full((n, 2), 1.0))
    assert (stated.jackknife, stated.misfit_p, stated.source) == (None, None, "propagation")
    assert stated.covariance is STATION


def test_without_changes_propagation_stands_alone() -> None:
    assert state_covariance(STATION, None).jackknife is None


def test_the_stated_region_holds_the_truth_where_sigmas_are_stated_right() -> None:
    assert 0.93 <= share_within(np.random.default_rng(7), 8, 1.0) <= 0.98


@pytest.mark.parametrize(("n", "worse"), [(8, 6.0), (5, 6.0), (8, 1.7)])
def test_the_stated_region_holds_the_truth_where_sigmas_are_stated_too_small(n: int, worse: float) -> None:
    assert 0.92 <= share_within(np.random.default_rng(8), n, worse) <= 0.99


def test_four_stations_make_no_jackknife() -> None:
    with pytest.raises(ShapeError, match=r"at least 5 stations, got \(4, 2\)"):
        jackknife_covariance(np.zeros((4, 2)))


def test_changes_that_are_not_finite_make_no_jackknife() -> None:
    with pytest.raises(ShapeError, match="finite changes"):
        jackknife_covariance(np.full((5, 2), np.nan))
