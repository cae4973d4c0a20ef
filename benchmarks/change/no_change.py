"""False alarms and power of the tests of change: campaigns of two epochs on the level of slices and poses.

.venv/bin/python -m benchmarks.change no_change [--trials 1000]
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.change.simulated_epochs import Site, State, Survey, axis_record
from tasks.change import detectable_factor, likeness
from tasks.change_basis import Kinship
from tasks.change_quantities import Quantity, changed_quantities
from tasks.change_rows import FULL_ARC_DEG

STILL = 60
"""Campaigns without change over which the stated covariance is averaged."""

RING = tuple(45.0 * k for k in range(8))
SIDE = (150.0, 165.0, 180.0, 195.0, 210.0)


@dataclass(frozen=True, slots=True)
class Case:
    """Two surveys of one wall, of a shaft that is bent by ``bend_m`` and stays so."""

    name: str
    first: Survey
    second: Survey
    wall_m: float = 0.0
    bend_m: float = 0.0


ONE_SIDE = Survey(SIDE, arc_deg=100.0)
CASES = (
    Case("eight stations, levels and positions as stated", Survey(RING), Survey(RING)),
    Case("levels 20 arcsec, stated so", Survey(RING, level_arcsec=20.0), Survey(RING, level_arcsec=20.0)),
    Case("four stations", Survey(RING[::2]), Survey(RING[::2])),
    Case("eight stations, then four", Survey(RING), Survey(RING[::2])),
    Case("one side only", ONE_SIDE, ONE_SIDE),
    Case("all around, then one side", Survey(RING), ONE_SIDE),
    Case("bent by 20 mm, then without the top fifth", Survey(RING), Survey(RING, top_m=80.0), bend_m=0.02),
    Case("wall off by 5 mm, the same stations", Survey(RING), Survey(RING), wall_m=0.005),
    Case(
        "levels 20 arcsec, stated 2.9",
        Survey(RING, drawn_level_arcsec=20.0),
        Survey(RING, drawn_level_arcsec=20.0),
    ),
    Case("wall off by 5 mm, then one side", Survey(RING), ONE_SIDE, wall_m=0.005),
)


def main(arguments: Sequence[str]) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(prog="benchmarks.change no_change", description=__doc__)
    parser.add_argument("--trials", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--cases", default="", help="parts of names of cases, separated by commas; all where none is given"
    )
    asked = parser.parse_args(arguments)
    print(
        f"{asked.trials} campaigns each; standard error of 5 %: {100 * np.sqrt(0.0475 / asked.trials):.1f} %\n"
    )
    print("| case | quantity | below 5 % | below 1 % | found at the smallest detectable change |")
    print("|---|---|---|---|---|")
    wanted = [case for case in CASES if any(part in case.name for part in asked.cases.split(","))]
    for case in wanted:
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
        for quantity in _compared(case, sites, rng, None):
            if quantity.p_value is not None:
                told.setdefault(quantity.quantity, []).append(quantity.p_value)
    return {name: np.array(values) for name, values in told.items()}


def power_of(case: Case, trials: int, seed: int) -> float:
    """Share of movements as large as the smallest detectable one that the 1 % test finds, in the worst direction."""
    rng = np.random.default_rng(seed)
    sites = [Site(survey, case.wall_m) for survey in (case.first, case.second)]
    covariance = np.mean([_lean(case, sites, rng, None).covariance for _ in range(STILL)], axis=0)
    values, vectors = np.linalg.eigh(covariance)
    detectable = detectable_factor(2) * np.sqrt(values[-1])
    moved = np.array(State().lean) + detectable * vectors[:, -1]
    counted = Counter(_lean(case, sites, rng, tuple(moved)).significant for _ in range(trials))
    return counted[True] / trials


def _lean(
    case: Case, sites: Sequence[Site], rng: np.random.Generator, later: tuple[float, float] | None
) -> Quantity:
    return next(one for one in _compared(case, sites, rng, later) if one.quantity == "lean")


def _compared(
    case: Case, sites: Sequence[Site], rng: np.random.Generator, later: tuple[float, float] | None
) -> list[Quantity]:
    still = State(bend_m=(case.bend_m, 0.0))
    moved = still if later is None else replace(still, lean=later)
    before = axis_record(sites[0], sites[0].draw(rng, still), 0)
    after = axis_record(sites[1], sites[1].draw(rng, moved), 1)
    return changed_quantities(before, after, kinship_of(sites))


def kinship_of(sites: Sequence[Site]) -> Kinship:
    """What two surveys have in common, as a run would find it."""
    seen = [site.seen() for site in sites]
    arcs = [10.0 * len(np.unique(one.azimuth_rad[one.n_points > 0.0])) for one in seen]
    return Kinship(
        alike=likeness(*seen),
        frame_of="before",
        partial=min(arcs) < FULL_ARC_DEG,
        fewest_stations=min(len(site.positions_m) for site in sites),
    )
