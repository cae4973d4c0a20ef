"""Change points: false alarms without one, and how often one is found, dated and measured rightly at epoch 7 of 12.

.venv/bin/python -m benchmarks.change change_points [--trials 400] [--seed 1]
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.change.simulated_series import Wander, asked_of, irregular_times, print_rows, simulated_series
from tasks.geometry.failure import FitFailure
from tasks.trend import ChangePoint, Kind, PlaneVector, find_change

ALONG = np.array([0.8, 0.6])
STILL = (Wander(0.001, 0.0), Wander(0.001, 0.001), Wander(0.001, 0.005))
MOVING = (Wander(0.001, 0.0), Wander(0.001, 0.001), Wander(0.002, 0.0), Wander(0.002, 0.002))
CHI2_95 = 5.991


@dataclass(frozen=True, slots=True)
class Change:
    """A change between the epochs 6 and 7 of twelve: a step, metres, or a rate that sets in, metres a year."""

    kind: Kind
    size: float


def main(arguments: Sequence[str]) -> None:
    """Print false alarms, then what becomes of changes."""
    asked = asked_of("change_points", __doc__, arguments, 400)
    print(f"Series without a change, {2 * asked.trials} each: a change point in % of cases at 5 % | at 1 %\n")
    print_rows(
        "epochs | noise (mm) | walk (mm/root a) | at 5 % | at 1 %",
        [
            f"{n} | {one.said} | {_alarms(2 * asked.trials, asked.seed, n, one)}"
            for n in (8, 12, 20)
            for one in STILL
        ],
    )
    print(
        "A movement that sets in between the epochs 6 and 7 of 12: found at 1 %; of those found, in % of cases\n"
    )
    changes = [Change("rate", size) for size in (0.004, 0.006, 0.010, 0.015)] + [
        Change("step", size) for size in (0.006, 0.010, 0.015)
    ]
    print_rows(
        "change | mm, mm/a | noise (mm) | walk (mm/root a) | found | kind right | onset in its interval"
        " | rate after in its region | before | change | interval (a) | rms of onset (a)",
        [
            f"{change.kind} | {1000 * change.size:g} | {one.said} | {_found(asked.trials, asked.seed, change, one)}"
            for change in changes
            for one in MOVING
        ],
    )


def _alarms(trials: int, seed: int, n: int, wander: Wander) -> str:
    rng = np.random.default_rng(seed)
    found = [_sought(rng, n, None, wander)[0] for _ in range(trials)]
    p = np.array([one.p_value for one in found])
    return " | ".join(f"{100 * np.mean(p < level):.1f}" for level in (0.05, 0.01))


def _sought(
    rng: np.random.Generator, n: int, change: Change | None, wander: Wander
) -> tuple[ChangePoint, float]:
    times = irregular_times(rng, n)
    onset = times[5] + rng.uniform() * (times[6] - times[5])
    shape = np.zeros(n)
    if change is not None:
        shape = change.size * (np.maximum(times - onset, 0.0) if change.kind == "rate" else times >= onset)
    found = find_change(simulated_series(rng, times, np.outer(shape, ALONG), wander), rng)
    if isinstance(found, FitFailure):
        raise SystemExit(found.reason)
    return found, onset


def _found(trials: int, seed: int, change: Change, wander: Wander) -> str:
    rng = np.random.default_rng(seed)
    every = [_sought(rng, 12, change, wander) for _ in range(trials)]
    clear = [(one, onset) for one, onset in every if one.p_value < 0.01]
    right = [(one, onset) for one, onset in clear if one.kind == change.kind]
    if not right:
        return f"{100 * len(clear) / trials:.0f} | - | - | - | - | - | - | -"
    after = change.size * ALONG if change.kind == "rate" else np.zeros(2)
    held = np.array(
        [
            [
                one.dated.earliest <= onset <= one.dated.latest,
                _inside(one.dated.rate_after, after),
                _inside(one.dated.rate_before, np.zeros(2)),
                _inside(one.dated.change, change.size * ALONG),
            ]
            for one, onset in right
        ]
    )
    width = np.mean([one.dated.latest - one.dated.earliest for one, _ in right])
    off = np.sqrt(np.mean([(one.dated.time - onset) ** 2 for one, onset in right]))
    shares = " | ".join(f"{100 * share:.1f}" for share in held.mean(axis=0))
    return f"{100 * len(clear) / trials:.0f} | {100 * len(right) / len(clear):.0f} | {shares} | {width:.2f} | {off:.2f}"


def _inside(found: PlaneVector, truth: np.ndarray) -> bool:
    off = found.value - truth
    return bool(off @ np.linalg.solve(found.covariance, off) < CHI2_95)
