"""Dates at which a limit is reached: how often the truth lies between the earliest and the latest.

.venv/bin/python -m benchmarks.change limit_dates [--trials 1000] [--seed 1]
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.change.simulated_series import Wander, asked_of, irregular_times, print_rows, simulated_series
from tasks.geometry.failure import FitFailure
from tasks.trend import LeanSeries, Terms, fit_trend, limit_date


@dataclass(frozen=True, slots=True)
class Case:
    """Movement at the last epoch, metres, rate, metres a year, and limit, metres."""

    said: str
    start: tuple[float, float]
    rate: tuple[float, float]
    limit_m: float
    n: int
    wander: Wander


CASES = (
    Case("lean far above its sigma", (0.2, 0.1), (0.004, 0.002), 0.4, 12, Wander(0.002, 0.0)),
    Case("the same with a walk", (0.2, 0.1), (0.004, 0.002), 0.4, 12, Wander(0.002, 0.001)),
    Case("lean zero", (0.0, 0.0), (0.001, 0.0), 0.03, 12, Wander(0.002, 0.0)),
    Case("lean zero, rate at its sigma", (0.0, 0.0), (0.0005, 0.0), 0.03, 8, Wander(0.002, 0.0)),
    Case("lean and limit at their sigma", (0.0, 0.0), (0.002, 0.0), 0.01, 8, Wander(0.004, 0.0)),
    Case("through the plumb", (-0.02, 0.003), (0.002, 0.0), 0.04, 12, Wander(0.002, 0.0)),
    Case("lean zero with a walk", (0.0, 0.0), (0.001, 0.0), 0.03, 12, Wander(0.002, 0.001)),
)


def main(arguments: Sequence[str]) -> None:
    """Print one row a case."""
    asked = asked_of("limit_dates", __doc__, arguments, 1000)
    rows = []
    for case in CASES:
        rng = np.random.default_rng(asked.seed)
        held = np.array([_held(rng, case) for _ in range(asked.trials)])
        earliest, latest = 100 * held.mean(axis=0)
        rows.append(f"{case.said} | {case.n} | {case.wander.said} | {earliest:.1f} | {latest:.1f}")
    print(f"{asked.trials} series each; the truth is the first time the true path is beyond the limit\n")
    print_rows(
        "case | epochs | noise (mm) | walk (mm/root a) | not before earliest % | not after latest %", rows
    )


def _held(rng: np.random.Generator, case: Case) -> tuple[bool, bool]:
    times = irregular_times(rng, case.n)
    walk = case.wander.walk_m
    steps = np.sqrt(np.diff(times, prepend=times[0]))[:, None] * rng.standard_normal((case.n, 2))
    true = np.array(case.start) + np.outer(times - times[-1], case.rate) + walk * np.cumsum(steps, axis=0)
    still = simulated_series(rng, times, true, Wander(case.wander.noise_m, 0.0))
    reached = _truth(rng, true[-1], case)
    found = _found(still, case.limit_m, walk > 0.0)
    return (100.0 if found[0] is None else found[0]) <= reached, found[1] is None or found[1] >= reached


def _found(series: LeanSeries, limit_m: float, walks: bool) -> tuple[float | None, float | None]:
    trend = fit_trend(series, Terms(rate=True, season=False, temperature=False, random_walk=walks, reason=""))
    if isinstance(trend, FitFailure):
        raise SystemExit(trend.reason)
    found = limit_date(trend.outlook, limit_m)
    return found.earliest, found.latest


def _truth(rng: np.random.Generator, last: NDArray[np.float64], case: Case) -> float:
    ahead = np.linspace(0.0, 100.0, 10001)
    steps = np.sqrt(ahead[1]) * case.wander.walk_m * rng.standard_normal((len(ahead), 2))
    path = last + np.outer(ahead, case.rate) + np.cumsum(steps, axis=0) - steps[0]
    beyond = np.flatnonzero(np.linalg.norm(path, axis=1) >= case.limit_m)
    return float(ahead[beyond[0]]) if len(beyond) else np.inf
