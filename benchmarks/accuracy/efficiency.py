"""How much of what the points know of the lean an estimate keeps: Cramer-Rao bound over mean squared error.

    .venv/bin/python -m benchmarks.accuracy efficiency [--trials 1500] [--estimators key] [--arcs 360,180,120,90]
        [--sigmas-mm 20,5] [--attached nothing,ladder,platform]

A shaft of 100 m, radius 4.5 to 2.5 m, lean 10 permille, 101 slices of 200 points. On a ladder lie 10 % of the points (30
degrees of azimuth), on platforms 30 % of those of every third slice, 0.2 to 1.2 m outside; the bound is that of the
points on the shaft. The stage functions are called as they are: no registration, nothing isolated.

In the mean squared error the share of luck that the best linear estimate of the same trial has too is replaced by its
known value, the bound: the standard error is several times smaller than that of the plain ratio, 1 / sqrt(trials).
"""

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final, get_args

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.bound import bound_of
from benchmarks.accuracy.estimators import chosen, leans_of
from benchmarks.accuracy.markdown import print_table
from benchmarks.accuracy.sliced_shaft import LEAN, Attached, Case, draw
from benchmarks.accuracy.trials import rng_of, run_trials
from tasks.conventions import ARCSEC_RAD
from tasks.geometry.failure import FitFailure

GOALS: Final[Mapping[float, float]] = {360.0: 0.97, 180.0: 0.95, 120.0: 0.95, 90.0: 0.85}
ROBUST_GOAL: Final = 0.90
OUTLIER_GOAL: Final = 0.85
SURFACE_GOAL: Final = 0.95


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """Trace of the bound, error (2,) of the best estimate, and of every estimator its error (2,) or a reason."""

    bound: float
    best_error: NDArray[np.float64]
    errors: Mapping[str, NDArray[np.float64] | str]


@dataclass(frozen=True, slots=True)
class Judged:
    """One estimator on one case; lengths in arc seconds, ``unbiased`` is the efficiency without the bias."""

    efficiency: float
    standard_error: float
    unbiased: float
    rms_arcsec: float
    bound_arcsec: float
    bias_arcsec: float
    bias_error_arcsec: float
    refused: int
    reason: str


def main(arguments: Sequence[str]) -> None:
    """Print a table of efficiencies, and one that tells what the estimators below their goal suffer from."""
    asked = _asked(arguments)
    names = chosen(asked.estimators)
    for attached in asked.attached.split(","):
        for sigma_mm in (float(word) for word in asked.sigmas_mm.split(",")):
            arcs = [float(word) for word in asked.arcs.split(",")]
            judged = {
                arc: _judge_all(Case(arc, sigma_mm * 1e-3, _attached(attached)), names, asked) for arc in arcs
            }
            print(f"Efficiency, {attached} attached, sigma {sigma_mm:g} mm, {asked.trials} trials\n")
            _print_overview(judged, names)
            _print_misses(judged, names, attached)


def _asked(arguments: Sequence[str]) -> argparse.Namespace:
    wanted = argparse.ArgumentParser(prog="efficiency", description=__doc__)
    wanted.add_argument("--trials", type=int, default=1500)
    wanted.add_argument("--seed", type=int, default=1)
    wanted.add_argument("--processes", type=int, default=2)
    wanted.add_argument("--estimators", default="key")
    wanted.add_argument("--arcs", default="360,180,120,90")
    wanted.add_argument("--sigmas-mm", default="20,5")
    wanted.add_argument("--attached", default=",".join(get_args(Attached)))
    return wanted.parse_args(arguments)


def _attached(name: str) -> Attached:
    for known in get_args(Attached):
        if name == known:
            return known  # type: ignore[no-any-return]
    raise SystemExit(f"unknown attachment {name!r}; known: {', '.join(get_args(Attached))}")


def _judge_all(case: Case, names: Sequence[str], asked: argparse.Namespace) -> dict[str, Judged]:
    trials = run_trials(partial(_trial, case, names, asked.seed), asked.trials, asked.processes)
    return {name: _judge(trials, name) for name in names}


def _trial(case: Case, names: Sequence[str], seed: int, number: int) -> Trial:
    drawn = draw(case, rng_of(seed, number))
    bound = bound_of(drawn)
    errors = {
        name: found.reason if isinstance(found, FitFailure) else found - LEAN
        for name, found in leans_of(drawn, names)
    }
    return Trial(float(np.trace(bound.covariance)), bound.best_error, errors)


def _judge(trials: Sequence[Trial], name: str) -> Judged:
    reasons = Counter(error for trial in trials if isinstance(error := trial.errors[name], str))
    used = [trial for trial in trials if not isinstance(trial.errors[name], str)]
    reason = reasons.most_common(1)[0][0] if reasons else ""
    if len(used) < 3:
        return Judged(*(float("nan"),) * 7, len(trials) - len(used), reason)
    errors = np.array([trial.errors[name] for trial in used])
    bounds = np.array([trial.bound for trial in used])
    best = np.array([trial.best_error for trial in used])
    square = np.sum(errors**2, axis=1)
    known = np.sum(best**2, axis=1) - bounds
    # regression on a quantity of mean zero: no bias, and no worse than without it where an estimate is all outliers
    share = float(np.cov(square, known)[0, 1] / np.var(known, ddof=1))
    mse = float(np.mean(square - share * known))
    mse_error = float(np.std(square - share * known, ddof=1)) / np.sqrt(len(used))
    bound = float(bounds.mean())
    bias = np.mean(errors - best, axis=0)
    bias_error = np.std(errors - best, axis=0, ddof=1) / np.sqrt(len(used))
    bias_square = float(bias @ bias - bias_error @ bias_error)
    return Judged(
        efficiency=bound / mse,
        standard_error=bound / mse * mse_error / mse,
        unbiased=bound / (mse - max(bias_square, 0.0)),
        rms_arcsec=float(np.sqrt(mse / 2.0)) / ARCSEC_RAD,
        bound_arcsec=float(np.sqrt(bound / 2.0)) / ARCSEC_RAD,
        bias_arcsec=float(np.hypot(*bias)) / ARCSEC_RAD,
        bias_error_arcsec=float(np.hypot(*bias_error)) / ARCSEC_RAD,
        refused=len(trials) - len(used),
        reason=reason,
    )


def _print_overview(judged: Mapping[float, Mapping[str, Judged]], names: Sequence[str]) -> None:
    head = ["estimator", *(f"{arc:g} deg" for arc in judged)]
    bound = ["bound", *(f'{next(iter(of.values())).bound_arcsec:.2f}"' for of in judged.values())]
    print_table(head, [bound, *([name, *(_cell(of[name]) for of in judged.values())] for name in names)])


def _cell(judged: Judged) -> str:
    refused = f" ({judged.refused} refused)" if judged.refused else ""
    return f"{judged.efficiency:.3f} ± {judged.standard_error:.3f}{refused}"


def _print_misses(judged: Mapping[float, Mapping[str, Judged]], names: Sequence[str], attached: str) -> None:
    rows = []
    for arc, of in judged.items():
        for name in names:
            goal, one = _goal(name, arc, attached), of[name]
            if goal is not None and not one.efficiency >= goal:
                rows.append([name, f"{arc:g}", f"{goal:.2f}", *_details(one)])
    if rows:
        print("Below the goal:\n")
        print_table(
            ["estimator", "arc", "goal", "efficiency", "without bias", 'rms (")', 'bias (")', "refused"], rows
        )


def _details(one: Judged) -> list[str]:
    return [
        _cell(one),
        f"{one.unbiased:.3f}",
        f"{one.rms_arcsec:.2f}",
        f"{one.bias_arcsec:.2f} ± {one.bias_error_arcsec:.2f}",
        one.reason,
    ]


def _goal(name: str, arc: float, attached: str) -> float | None:
    """What is wanted of an estimator; None where nothing is."""
    robust = name.startswith("robust_circle")
    if name.startswith("surface shaft"):
        return SURFACE_GOAL if attached == "nothing" else OUTLIER_GOAL
    if attached != "nothing":
        return OUTLIER_GOAL if robust else None
    if name == "geometric_circle + weighted_line":
        return GOALS.get(arc, 0.95)
    return min(ROBUST_GOAL, GOALS.get(arc, 0.95)) if robust else None
