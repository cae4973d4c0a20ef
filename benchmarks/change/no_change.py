"""False alarms and power of the tests of change: campaigns of two epochs on the level of slices and poses.

    .venv/bin/python -m benchmarks.change no_change [--trials 1000]
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.change.simulated_epochs import Site, State, Survey, axis_record
from tasks.change import detectable_factor
from tasks.change_quantities import Kinship, Quantity, changed_quantities

STILL = 60
"""Campaigns without change over which the stated covariance is averaged."""

RING = tuple(45.0 * k for k in range(8))
SIDE = (150.0, 165.0, 180.0, 195.0, 210.0)


@dataclass(frozen=True, slots=True)
class Case:
    """Two surveys of one wall, and what the comparison takes them for."""

    name: str
    first: Survey
    second: Survey
    wall_m: float = 0.0
    partial: bool = False
    alike: float = 1.0


CASES = (
    Case("eight stations, levels and positions as stated", Survey(RING), Survey(RING)),
    Case("levels 20 arcsec, stated so", Survey(RING, level_arcsec=20.0), Survey(RING, level_arcsec=20.0)),
    Case("four stations", Survey(RING[::2]), Survey(RING[::2])),
    Case("wall off by 5 mm, the same stations", Survey(RING), Survey(RING), wall_m=0.005),
    Case(
        "one side only, radius held", Survey(SIDE, arc_deg=100.0), Survey(SIDE, arc_deg=100.0), partial=True
    ),
)


def main(arguments: Sequence[str]) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="benchmarks.change no_change", description=__doc__)
    parser.add_argument("--trials", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args(arguments)
    print(
        f"{asked.trials} campaigns each; standard error of 5 %: {100 * np.sqrt(0.0475 / asked.trials):.1f} %\n"
    )
    print("| case | quantity | below 5 % | below 1 % | found at the smallest detectable change |")
    print("|---|---|---|---|---|")
    for case in CASES:
        found = false_alarms(case, asked.trials, asked.seed)
        power = power_of(case, asked.trials, asked.seed + 1)
        for quantity, p_values in found.items():
            shares = " | ".join(f"{100 * np.mean(p_values < level):.1f} %" for level in (0.05, 0.01))
            told = f"{100 * power:.1f} %" if quantity == "lean" else ""
            print(f"| {case.name} | {quantity} | {shares} | {told} |")


def false_alarms(case: Case, trials: int, seed: int) -> dict[str, NDArray[np.float64]]:
    """P values (trials,) of every quantity where nothing changed."""
    rng = np.random.default_rng(seed)
    sites = [Site(survey, case.wall_m) for survey in (case.first, case.second)]
    told: dict[str, list[float]] = {}
    for _ in range(trials):
        for quantity in _compared(case, sites, rng, State()):
            if quantity.p_value is not None:
                told.setdefault(quantity.quantity, []).append(quantity.p_value)
    return {name: np.array(values) for name, values in told.items()}


def power_of(case: Case, trials: int, seed: int) -> float:
    """Share of movements as large as the smallest detectable one that the 1 % test finds, in the worst direction."""
    rng = np.random.default_rng(seed)
    sites = [Site(survey, case.wall_m) for survey in (case.first, case.second)]
    covariance = np.mean([_lean(case, sites, rng, State()).covariance for _ in range(STILL)], axis=0)
    values, vectors = np.linalg.eigh(covariance)
    detectable = detectable_factor(2) * np.sqrt(values[-1])
    moved = np.array(State().lean) + detectable * vectors[:, -1]
    counted = Counter(_lean(case, sites, rng, State(lean=tuple(moved))).significant for _ in range(trials))
    return counted[True] / trials


def _lean(case: Case, sites: Sequence[Site], rng: np.random.Generator, later: State) -> Quantity:
    return next(one for one in _compared(case, sites, rng, later) if one.quantity == "lean")


def _compared(case: Case, sites: Sequence[Site], rng: np.random.Generator, later: State) -> list[Quantity]:
    before = axis_record(sites[0], sites[0].draw(rng, State()), 0)
    after = axis_record(sites[1], sites[1].draw(rng, later), 1)
    kinship = Kinship(alike=case.alike, before_holds_frame=True, partial=case.partial)
    return changed_quantities(before, after, kinship)
