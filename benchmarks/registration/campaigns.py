"""Every method on the same simulated campaigns: the lean vector, the poses, the time.

    .venv/bin/python -m benchmarks.registration campaigns [--seeds 20] [--stations 8,3,4,5] [--points 200000]

Lean errors are lengths of the vector, RMS over the campaigns. "true" has true positions and headings with the
scanners taken as plumb: the floor that the levelling leaves. Slices and fits (scheme A, robust) are the same for all.
"Relative" is what one shift and one turn of the whole network do not explain. Where a method leaves the clouds so far
apart that no shaft is found in them ("no shaft"), its lean is that of the points that true poses find.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.registration import stated_sigma
from benchmarks.registration.campaign_table import figures, print_table
from benchmarks.registration.methods import METHODS, chosen
from benchmarks.registration.outcome import Outcome, evaluate, with_true_shaft
from benchmarks.registration.simulated import simulated_epoch
from tasks.conventions import ARCSEC_RAD
from tasks.open3d_import import import_open3d
from tasks.registration import planar
from tasks.simulation import SimulatedCampaignRequest


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the campaigns and print the tables for every number of stations."""
    asked = _arguments(arguments)
    if asked.registered is not None:
        planar.MOST_POINTS = asked.registered
    import_open3d()  # so that its loading is in nobody's time
    everything: list[Outcome] = []
    for stations in map(int, asked.stations.split(",")):
        outcomes = _run(asked, stations)
        everything += outcomes
        print(f"\n{asked.seeds} campaigns of {stations} stations of {asked.points} points")
        print_table(outcomes)
        _print_sigmas(outcomes)
    if asked.json:
        asked.json.write_text(json.dumps(list(figures(everything)), indent=1))


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    wanted = argparse.ArgumentParser(
        prog="campaigns", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    wanted.add_argument("--seeds", type=int, default=20)
    wanted.add_argument("--first-seed", type=int, default=2000)
    wanted.add_argument("--stations", default="8", help="one number or several: 8,3,4,5")
    wanted.add_argument("--points", type=int, default=200_000, help="of each station")
    wanted.add_argument("--registered", type=int, help="points of each station that ours looks at, at most")
    wanted.add_argument("--methods", type=chosen, default=",".join(METHODS))
    wanted.add_argument("--cache", type=Path, help="folder that keeps the simulated scans")
    wanted.add_argument("--json", type=Path, help="file for all figures")
    return wanted.parse_args(arguments)


def _run(asked: argparse.Namespace, stations: int) -> list[Outcome]:
    outcomes = []
    for seed in range(asked.first_seed, asked.first_seed + asked.seeds):
        request = SimulatedCampaignRequest(epochs=1, stations=stations, points=asked.points, seed=seed)
        epoch = simulated_epoch(request, asked.cache)
        several = [with_true_shaft(epoch, evaluate(epoch, method)) for method in asked.methods]
        print(f"{epoch.label}, {stations} stations:", *map(_short, several), file=sys.stderr, flush=True)
        outcomes += several
    return outcomes


def _short(outcome: Outcome) -> str:
    if outcome.error is None:
        return f" {outcome.method} failed ({outcome.failure})"
    east, north = outcome.error / ARCSEC_RAD
    remarks = outcome.notes if outcome.failure is None else (*outcome.notes, outcome.failure)
    notes = f" [{'; '.join(remarks)}]" if remarks else ""
    return f' {outcome.method} {east:+.2f}" {north:+.2f}" {outcome.seconds:.1f} s{notes}'


def _print_sigmas(outcomes: Sequence[Outcome]) -> None:
    """Judge the covariance of ours; the other methods state none."""
    pairs = [
        (o.poses.errors, o.registration.covariance)
        for o in outcomes
        if o.method == "ours" and o.poses is not None and o.registration is not None
    ]
    if not pairs:
        return
    print("\nstated sigma of our poses against their scatter")
    stated_sigma.print_table(
        [one for pair in pairs for one in stated_sigma.check(*pair)],
        [stated_sigma.whole(*pair) for pair in pairs],
    )
    chi2 = np.array([o.chi2 for o in outcomes if o.method == "ours" and o.chi2 is not None])
    print(f"lean of ours: chi-square {chi2.mean():.2f} on average (2 where the covariance is true)")
