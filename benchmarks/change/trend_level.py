"""False alarms of the rate test under random walks, with the walk ignored, estimated, and averaged over; its power.

.venv/bin/python -m benchmarks.change trend_level [--trials 1000] [--seed 1]
"""

import argparse
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.change.simulated_series import Wander, asked_of, irregular_times, print_rows, simulated_series
from tasks.geometry.failure import FitFailure
from tasks.trend import LeanSeries, Terms, fit_trend, gls_at
from tasks.trend.outlook import mean_p_value

WITH_WALK = Terms(rate=True, season=False, temperature=False, random_walk=True, reason="")
EPOCHS = (6, 8, 12, 16, 40)
WANDERS = (
    *(Wander(0.001, walk) for walk in (0.0, 0.0005, 0.001, 0.002, 0.005)),
    Wander(0.003, 0.001),
    Wander(0.003, 0.002),
)


def main(arguments: Sequence[str]) -> None:
    """Print the share of series with a rate below p = 0.05 and 0.01, first without any rate, then with one."""
    asked = asked_of("trend_level", __doc__, arguments, 1000)
    print(
        f"Series without a rate, {asked.trials} each, half-yearly to yearly: false alarms in % at 5 % | at 1 %\n"
    )
    head = "epochs | noise (mm) | walk (mm/root a) | walk ignored 5 % | 1 % | best walk 5 % | 1 % | averaged 5 % | 1 %"
    rows = [f"{n} | {one.said} | {_row(asked, n, one, 0.0)}" for n in EPOCHS for one in WANDERS]
    print_rows(head, rows)
    print("Series of 12 epochs with a rate (mm/a): found in % of cases\n")
    found = [
        f"{1000 * rate:g} | {one.said} | {_row(asked, 12, one, rate)}"
        for one in (Wander(0.001, 0.0), Wander(0.001, 0.001))
        for rate in (0.001, 0.002, 0.003, 0.005)
    ]
    print_rows(head.replace("epochs", "rate", 1), found)


def _row(asked: argparse.Namespace, n: int, wander: Wander, rate: float) -> str:
    rng = np.random.default_rng(asked.seed)
    times = irregular_times(rng, n)
    moved = np.outer(times, [rate, 0.0])
    p = np.array([_p_values(simulated_series(rng, times, moved, wander)) for _ in range(asked.trials)])
    return " | ".join(f"{100 * np.mean(p[:, k] < level):.1f}" for k in range(3) for level in (0.05, 0.01))


def _p_values(series: LeanSeries) -> tuple[float, float, float]:
    """Without a walk, with the best one taken for true, and averaged."""
    trend = fit_trend(series, WITH_WALK)
    if isinstance(trend, FitFailure) or trend.random_walk is None:
        raise SystemExit("the benchmark asks for a trend of too few epochs")
    columns = np.column_stack([np.ones(series.n_epochs), series.times - series.times[-1]])
    return _at(series, columns, 0.0), _at(series, columns, trend.random_walk), trend.rate_p_value


def _at(series: LeanSeries, columns: NDArray[np.float64], walk: float) -> float:
    found = gls_at(series, columns, walk)
    return mean_p_value(np.ones(1), found.values[None, 2:4], found.covariance[None, 2:4, 2:4])
