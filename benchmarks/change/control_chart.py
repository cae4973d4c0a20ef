"""Run lengths of the control chart: simulated, against those that are computed, and against published ones.

.venv/bin/python -m benchmarks.change control_chart [--trials 40000] [--seed 1]
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.change.simulated_series import asked_of, print_rows
from tasks.trend import ALARM_RUN_LENGTH, WATCH_RUN_LENGTH, average_run_length, control_limit

ALLOWANCE = 0.5


def main(arguments: Sequence[str]) -> None:
    """Print one row for every limit, number of charts and shift."""
    asked = asked_of("control_chart", __doc__, arguments, 40000)
    limits = [(4.0, 1), (5.0, 1), (control_limit(WATCH_RUN_LENGTH), 2), (control_limit(ALARM_RUN_LENGTH), 2)]
    rows = []
    for limit, charts in limits:
        for shift in (0.0, 1.0, 2.0):
            rng = np.random.default_rng(asked.seed)
            found = run_lengths(rng, limit, shift, charts, asked.trials)
            computed = average_run_length(ALLOWANCE, limit, shift, charts)
            error = found.std() / np.sqrt(len(found))
            rows.append(
                f"{charts} | {limit:.4f} | {shift:g} | {computed:.2f} | {found.mean():.2f} ± {error:.2f}"
            )
    print(f"Epochs to the first signal, k = {ALLOWANCE}, {asked.trials} series each\n")
    print_rows("charts | limit h | shift (sigma) | computed | simulated", rows)


def run_lengths(
    rng: np.random.Generator, limit: float, shift: float, charts: int, trials: int
) -> NDArray[np.float64]:
    """Epochs until the first of the charts signals, in each of the trials; all run until they have."""
    up, down, done, epoch = np.zeros((trials, charts)), np.zeros((trials, charts)), [], 0
    while len(up):
        epoch += 1
        drawn = rng.standard_normal(up.shape)
        drawn[:, 0] += shift
        up, down = np.maximum(0.0, up + drawn - ALLOWANCE), np.maximum(0.0, down - drawn - ALLOWANCE)
        signals = np.maximum(up, down).max(axis=1) >= limit
        done.append(np.full(np.count_nonzero(signals), float(epoch)))
        up, down = up[~signals], down[~signals]
    return np.concatenate(done)
