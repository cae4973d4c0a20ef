"""Series of many epochs: what the chain gives is what the dense formula gives, and costs what their number costs."""

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.trend import DAYS_A_YEAR, LeanSeries, Terms, Trend, design_columns, fit_trend, gls_at
from tasks.trend.change_dating import date_change
from tasks.trend.change_point import ChangePoint, find_change
from tasks.trend.long_series import at_sigma, chain_model, chain_sigma
from tasks.trend.onsets import Kind
from tasks.trend.walk import build_model, rotate, walk_sigma
from tests.unit.trend.known_series import dense_covariance, drawn, irregular_times, some_covariances

ALL_TERMS = Terms(rate=True, season=True, temperature=False, random_walk=True, reason="")
LINE = Terms(rate=True, season=False, temperature=False, random_walk=True, reason="")


def some_series(seed: int = 3, n: int = 40, walk: float = 0.001, twice: bool = False) -> LeanSeries:
    rng = np.random.default_rng(seed)
    times = irregular_times(rng, n)
    if twice:
        times[[1, 7, 8]] = times[[0, 6, 6]]
        times.sort()
    return drawn(rng, times, some_covariances(rng, n, 0.001), 2.0 + np.outer(times, [0.002, -0.001]), walk)


@pytest.mark.parametrize("twice", [False, True])
@pytest.mark.parametrize("walk", [0.0, 1e-6, 0.0004, 0.02])
def test_estimate_of_the_chain_is_that_of_the_model_taken_apart(walk: float, twice: bool) -> None:
    series = some_series(twice=twice)
    columns = design_columns(series, ALL_TERMS)
    ours, known = at_sigma(chain_model(series, columns), walk).estimate, gls_at(series, columns, walk)
    sigmas = np.sqrt(np.diag(known.covariance))
    np.testing.assert_allclose((ours.values - known.values) / sigmas, 0.0, atol=1e-7)
    np.testing.assert_allclose(
        ours.covariance / np.outer(sigmas, sigmas), known.covariance / np.outer(sigmas, sigmas), atol=1e-7
    )


def test_restricted_likelihood_and_misfit_of_the_chain_are_those_of_the_dense_formula() -> None:
    series = some_series(twice=True)
    columns = design_columns(series, ALL_TERMS)
    X, y = np.kron(columns, np.eye(2)), series.movements.reshape(-1)
    model, differences = chain_model(series, columns), []
    for sigma in (0.0, 0.0005, 0.001, 0.01):
        V = dense_covariance(series, sigma)
        inverse = np.linalg.inv(V)
        information = X.T @ inverse @ X
        residual = y - X @ np.linalg.solve(information, X.T @ inverse @ y)
        misfit = residual @ inverse @ residual
        dense = -0.5 * (np.linalg.slogdet(V)[1] + np.linalg.slogdet(information)[1] + misfit)
        found = at_sigma(model, sigma)
        assert found.misfit == pytest.approx(misfit, rel=1e-7)
        differences.append(found.log_likelihood - dense)
    np.testing.assert_allclose(differences, differences[0], atol=1e-6)


@pytest.mark.parametrize("apart_s", [1e-6, 1e-3, 0.5])
@pytest.mark.parametrize("walk", [1e-6, 0.0004, 0.02])
def test_epochs_moments_apart_do_not_drown_the_chain_in_rounding(walk: float, apart_s: float) -> None:
    rng = np.random.default_rng(4)
    first = np.arange(150) / 52.0
    times = np.sort(np.concatenate([first, first + apart_s / (86_400.0 * DAYS_A_YEAR)]))
    series = drawn(rng, times, some_covariances(rng, 300, 0.0001), np.outer(times, [0.002, -0.001]), 0.001)
    columns = design_columns(series, LINE)
    ours, known = at_sigma(chain_model(series, columns), walk).estimate, gls_at(series, columns, walk)
    sigmas = np.sqrt(np.diag(known.covariance))
    np.testing.assert_allclose((ours.values - known.values) / sigmas, 0.0, atol=1e-3)
    np.testing.assert_allclose(np.diag(ours.covariance) / sigmas**2, 1.0, atol=1e-3)


def test_epochs_within_a_moment_are_no_chain() -> None:
    series = some_series(n=10)
    series.times[:] = np.linspace(0.0, 1e-9, 10)
    with pytest.raises(ShapeError, match="2 times"):
        chain_model(series, np.ones((10, 1)))


@pytest.mark.parametrize("walk", [0.0, 0.001, 0.01])
def test_sigma_of_the_walk_is_that_of_the_model_taken_apart(walk: float) -> None:
    series = some_series(walk=walk)
    columns = design_columns(series, ALL_TERMS)
    model = build_model(series, columns, True)
    known = walk_sigma(model, rotate(model, series.movements.reshape(-1)).left)
    found = chain_sigma(chain_model(series, columns))
    assert found.reml == pytest.approx(known.reml, abs=1e-5, rel=1e-3)
    mean, expected = found.nodes @ found.weights, known.nodes @ known.weights
    assert mean == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("walk", [0.0, 0.003])
def test_the_trend_of_a_long_series_is_that_of_the_model_taken_apart(
    walk: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    series = some_series(n=60, walk=walk)
    known = fit_trend(series)
    monkeypatch.setattr("tasks.trend.gls.LONG_EPOCHS", 10)
    found = fit_trend(series)
    assert isinstance(known, Trend)
    assert isinstance(found, Trend)
    sigma = np.sqrt(np.trace(known.rate.covariance))
    # the nodes over which both average are not the same
    np.testing.assert_allclose(found.rate.value / sigma, known.rate.value / sigma, atol=0.02)
    np.testing.assert_allclose(found.rate.covariance, known.rate.covariance, rtol=0.03, atol=0.03 * sigma**2)
    assert found.misfit_p == pytest.approx(known.misfit_p, abs=0.01)


@pytest.mark.slow
def test_the_change_point_of_a_long_series_is_that_of_the_model_taken_apart(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    series = some_series(n=40)
    series.movements[20:] += 0.03
    known = find_change(series, np.random.default_rng(1))
    monkeypatch.setattr("tasks.trend.change_dating.LONG_EPOCHS", 10)
    found = find_change(series, np.random.default_rng(1))
    assert isinstance(known, ChangePoint)
    assert isinstance(found, ChangePoint)
    assert (found.kind, found.first_epoch, found.p_value) == (known.kind, known.first_epoch, known.p_value)
    assert found.dated.change.size == pytest.approx(known.dated.change.size, rel=0.01)
    assert found.dated.change.sigma == pytest.approx(known.dated.change.sigma, rel=0.03)


@pytest.mark.parametrize("kind", ["step", "rate"])
def test_onsets_looked_at_in_blocks_give_what_all_of_them_give_together(
    monkeypatch: pytest.MonkeyPatch, kind: Kind
) -> None:
    series = some_series(n=30)
    series.movements[15:] += 0.01
    columns = design_columns(
        series, Terms(rate=True, season=False, temperature=False, random_walk=True, reason="")
    )
    model, near = build_model(series, columns, True), float(series.times[15])
    known = date_change(series, columns, model, kind, near)
    monkeypatch.setattr("tasks.trend.change_dating.MOST_NUMBERS", 7 * 4 * 30)
    found = date_change(series, columns, model, kind, near)
    assert (found.time, found.earliest, found.latest) == (known.time, known.earliest, known.latest)
    np.testing.assert_allclose(found.change.value, known.change.value, rtol=1e-9)
    np.testing.assert_allclose(found.rate_after.covariance, known.rate_after.covariance, rtol=1e-9)
