"""Change points against an exhaustive search, ruptures, and series whose change is known."""

import numpy as np
import pytest
import ruptures
import statsmodels.api as sm
from numpy.typing import NDArray
from scipy import stats

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.trend import ChangePoint, Kind, LeanSeries, Terms, change_column, design_columns, find_change
from tasks.trend.change_point import scan_onsets
from tasks.trend.change_scan import likelihood_ratios, scan_of, scan_sigmas
from tasks.trend.onsets import change_columns, onsets_between
from tasks.trend.walk import build_model, rotate, walk_sigma
from tests.unit.trend.known_series import (
    LINE,
    LINE_AND_WALK,
    dense_covariance,
    drawn,
    irregular_times,
    some_covariances,
)

ALONG = np.array([0.8, 0.6])


def change_of(
    series: LeanSeries, terms: Terms | None = None, kinds: tuple[Kind, ...] = ("step", "rate")
) -> ChangePoint:
    found = find_change(series, np.random.default_rng(0), terms, kinds)
    assert isinstance(found, ChangePoint), found
    return found


def shape(times: NDArray[np.float64], kind: Kind, onset: float) -> NDArray[np.float64]:
    return np.maximum(times - onset, 0.0) if kind == "rate" else (times >= onset).astype(float)


def campaign(
    seed: int, kind: Kind, size: float, sigma_m: float = 0.001, walk: float = 0.0
) -> tuple[LeanSeries, float]:
    """Twelve epochs, half-yearly to yearly; the movement starts between the sixth and the seventh."""
    rng = np.random.default_rng(seed)
    times = irregular_times(rng, 12)
    onset = times[5] + rng.uniform() * (times[6] - times[5])
    moved = np.outer(size * shape(times, kind, onset), ALONG)
    return drawn(rng, times, some_covariances(rng, 12, sigma_m), moved, walk), float(onset)


def test_a_movement_that_starts_at_the_seventh_of_twelve_epochs_is_found_dated_and_measured() -> None:
    """8 mm a year, sigma of an epoch 1 mm."""
    series, onset = campaign(1, "rate", 0.008)
    found = change_of(series)
    assert found.p_value < 0.01
    assert (found.kind, found.first_epoch) == ("rate", 6)
    assert found.dated.earliest <= onset <= found.dated.latest
    assert abs(found.dated.time - onset) < 0.5
    assert abs(found.dated.rate_after.size - 0.008) < 2.0 * found.dated.rate_after.sigma
    assert found.dated.rate_before.size < 3.0 * found.dated.rate_before.sigma


@pytest.mark.parametrize(("kind", "size"), [("rate", 0.010), ("step", 0.010)])
def test_stated_regions_of_a_change_hold_the_truth(kind: Kind, size: float) -> None:
    """Of 60 campaigns: onset, rate after and change each within their 95 %, at odds of 1000 to 1; the kind is told."""
    held, kinds = np.zeros(3), 0
    for seed in range(60):
        series, onset = campaign(seed, kind, size, walk=0.001)
        found = change_of(series)
        kinds += found.kind == kind
        dated = found.dated
        after = size * ALONG if kind == "rate" else np.zeros(2)
        held += [
            dated.earliest <= onset <= dated.latest,
            chi2(dated.rate_after.value - after, dated.rate_after.covariance) < 5.991,
            chi2(dated.change.value - size * ALONG, dated.change.covariance) < 5.991,
        ]
    assert kinds >= 57
    assert held.min() >= stats.binom.ppf(0.001, 60, 0.95)


def chi2(off: NDArray[np.float64], covariance: NDArray[np.float64]) -> float:
    return float(off @ np.linalg.solve(covariance, off))


@pytest.mark.parametrize("walk", [0.0, 0.002])
def test_false_change_points_are_as_rare_as_stated(walk: float) -> None:
    """Of 120 still or wandering series at most as many as 5 % allow at odds of 1000 to 1."""
    rng = np.random.default_rng(9)
    p = []
    for _ in range(120):
        series = drawn(rng, irregular_times(rng, 12), some_covariances(rng, 12, 0.001), walk=walk)
        p.append(change_of(series).p_value)
    assert np.count_nonzero(np.array(p) < 0.05) <= stats.binom.ppf(0.999, 120, 0.05)


def test_without_a_walk_the_p_value_is_uniform() -> None:
    rng = np.random.default_rng(10)
    times, covariances = irregular_times(rng, 10), some_covariances(rng, 10, 0.001)
    p = [change_of(drawn(rng, times, covariances), LINE).p_value for _ in range(150)]
    assert stats.kstest(p, "uniform").pvalue > 0.01


def test_gain_of_every_onset_is_that_of_generalised_least_squares() -> None:
    """Against statsmodels, with the same dense covariance, onset by onset."""
    series, _ = campaign(2, "rate", 0.004)
    columns, y = design_columns(series, LINE), series.movements.reshape(-1)
    model = build_model(series, columns, False)
    onsets = onsets_between(series, "rate", 2)
    left = rotate(model, y).left
    candidates = rotate(model, change_columns(series, onsets)).left.T.reshape(-1, 2, len(left))
    ours = likelihood_ratios(scan_of(model, candidates, walk_sigma(model, left)), left[:, None])[:, 0]

    def squares(X: NDArray[np.float64]) -> float:
        fit = sm.GLS(y, np.kron(X, np.eye(2)), sigma=dense_covariance(series, 0.0)).fit()
        return float(fit.ssr)

    plain = squares(columns)
    theirs = [
        plain - squares(np.column_stack([columns, change_column(series, "rate", onset)]))
        for onset in onsets.times
    ]
    np.testing.assert_allclose(ours, theirs, rtol=1e-8, atol=1e-8)


def test_a_walk_is_given_its_best_sigma_with_and_without_the_change() -> None:
    series, _ = campaign(3, "step", 0.004, walk=0.002)
    columns = design_columns(series, LINE_AND_WALK)
    model = build_model(series, columns, True)
    onsets = onsets_between(series, "step", 1)
    left = rotate(model, series.movements.reshape(-1)).left
    walk = walk_sigma(model, left)
    candidates = rotate(model, change_columns(series, onsets)).left.T.reshape(-1, 2, len(left))
    ours = likelihood_ratios(scan_of(model, candidates, walk), left[:, None])[:, 0]
    H = candidates[4].T
    plain, better = [], []
    for sigma in scan_sigmas(walk):
        V = np.diag(1.0 + sigma**2 * model.spectrum)
        rest = (
            left
            - H
            @ np.linalg.lstsq(np.linalg.solve(np.sqrt(V), H), np.linalg.solve(np.sqrt(V), left), rcond=None)[
                0
            ]
        )
        plain.append(np.linalg.slogdet(V)[1] + left @ np.linalg.solve(V, left))
        better.append(np.linalg.slogdet(V)[1] + rest @ np.linalg.solve(V, rest))
    assert ours[4] == pytest.approx(min(plain) - min(better), rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_a_step_lies_where_ruptures_puts_it(seed: int) -> None:
    """White noise and nothing but a level: least squares in two parts, which Dynp finds by dynamic programming."""
    rng = np.random.default_rng(seed)
    times = np.arange(20.0)
    moved = np.where(times >= 8, 0.003, 0.0)[:, None] * ALONG
    series = drawn(rng, times, np.tile(1e-6 * np.eye(2), (20, 1, 1)), moved)
    theirs = ruptures.Dynp(model="l2", min_size=2, jump=1).fit(series.movements).predict(n_bkps=1)[0]
    level = build_model(series, np.ones((20, 1)), False)
    best = scan_onsets(level, series, [onsets_between(series, "step", 1)], rng)
    assert int(np.searchsorted(times, best.time)) == theirs


def test_a_turned_frame_finds_the_same_change() -> None:
    series, _ = campaign(4, "rate", 0.008, walk=0.001)
    R = np.array([[0.6, -0.8], [0.8, 0.6]])
    turned = LeanSeries(series.times, series.movements @ R.T, R @ series.covariances @ R.T)
    before, after = change_of(series).dated, change_of(turned).dated
    assert after.time == before.time
    np.testing.assert_allclose(after.rate_after.value, R @ before.rate_after.value, rtol=1e-4)
    np.testing.assert_allclose(
        after.rate_after.covariance, R @ before.rate_after.covariance @ R.T, rtol=1e-3, atol=1e-10
    )


def test_a_single_epoch_that_is_off_at_the_end_is_no_change_point() -> None:
    onsets = onsets_between(campaign(5, "rate", 0.0)[0], "rate", 4)
    times = campaign(5, "rate", 0.0)[0].times
    assert times[1] < onsets.times.min()
    assert onsets.times.max() < times[-2]
    assert onsets.widths.sum() == pytest.approx(times[-2] - times[1])


def test_too_few_epochs_have_no_change_point_and_a_reason() -> None:
    rng = np.random.default_rng(1)
    found = find_change(drawn(rng, irregular_times(rng, 6), some_covariances(rng, 6, 0.001)), rng)
    assert isinstance(found, FitFailure)
    assert found.reason == "no change point: 6 epochs, needs 7"


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ShapeError, match="step, rate"):
        find_change(campaign(5, "rate", 0.0)[0], np.random.default_rng(1), kinds=())


def test_the_same_seed_gives_the_same_p_value() -> None:
    series, _ = campaign(6, "rate", 0.002)
    assert change_of(series).p_value == change_of(series).p_value


def test_epochs_of_one_instant_do_not_break_the_search() -> None:
    rng = np.random.default_rng(7)
    times = np.sort(np.concatenate([irregular_times(rng, 8)] * 3))
    found = change_of(drawn(rng, times, some_covariances(rng, 24, 0.001)))
    assert times[1] < found.dated.earliest < found.dated.latest < times[-1]
    twice = np.repeat([0.0, 1.0], 6)
    assert isinstance(find_change(drawn(rng, twice, some_covariances(rng, 12, 0.001)), rng), FitFailure)
