"""Does the stated 95 % region of the lean vector hold the truth in 95 of 100 campaigns.

    .venv/bin/python -m benchmarks.accuracy coverage [--trials 500] [--campaigns noise,poses,...] [--ways S/surface,...]

Stations stand evenly around at 250 m; each sees its side of a leaning, tapering shaft of 100 m with a range noise of 6 mm
and 5" across. Poses are off by what is drawn and come with the covariance that is stated. Walls are drawn anew in every
trial.
"""

import argparse
from collections.abc import Sequence

import numpy as np

from benchmarks.accuracy.campaign_trials import WAYS, Outcome, Stated, outcomes_of
from benchmarks.accuracy.known_campaign import CAMPAIGNS
from benchmarks.accuracy.markdown import print_table
from tasks.conventions import ARCSEC_RAD
from tasks.geometry.failure import FitFailure
from tasks.geometry.plane_vectors import CHI2_95


def main(arguments: Sequence[str]) -> None:
    """Print one row for every campaign, scheme and method."""
    asked = asked_of("coverage", __doc__, arguments)
    rows = []
    for name in asked.campaigns.split(","):
        ways = asked.ways.split(",")
        for way, outcomes in outcomes_of(name, ways, asked.trials, asked.processes, asked.seed).items():
            rows.append([CAMPAIGNS[name].title, way, *_cells(outcomes)])
    print(f"Coverage, {asked.trials} trials\n")
    head = ["campaigns", "by", 'rms (")', 'stated (")', "chi2 mean", "in 95 %", "jackknife", "refused"]
    print_table(head, rows)


def asked_of(name: str, description: str | None, arguments: Sequence[str]) -> argparse.Namespace:
    """Options of the commands that draw campaigns."""
    wanted = argparse.ArgumentParser(prog=name, description=description)
    wanted.add_argument("--trials", type=int, default=500)
    wanted.add_argument("--seed", type=int, default=1)
    wanted.add_argument("--processes", type=int, default=2)
    wanted.add_argument("--campaigns", default=",".join(CAMPAIGNS))
    wanted.add_argument("--ways", default=",".join(WAYS))
    asked = wanted.parse_args(arguments)
    unknown = [campaign for campaign in asked.campaigns.split(",") if campaign not in CAMPAIGNS]
    if unknown:
        raise SystemExit(f"unknown campaigns {', '.join(unknown)}; known: {', '.join(CAMPAIGNS)}")
    return asked


def _cells(outcomes: Sequence[Outcome]) -> list[str]:
    found = [outcome for outcome in outcomes if isinstance(outcome, Stated)]
    reasons = {outcome.reason for outcome in outcomes if isinstance(outcome, FitFailure)}
    refused = f"{len(outcomes) - len(found)}: {min(reasons)}" if reasons else "0"
    if not found:
        return ["-", "-", "-", "-", "-", refused]
    chi2 = np.array([one.chi2 for one in found])
    inside = float(np.mean(chi2 < CHI2_95))
    error = float(np.sqrt(inside * (1.0 - inside) / len(found)))
    rms = np.sqrt(np.mean([one.error @ one.error / 2.0 for one in found])) / ARCSEC_RAD
    stated = np.sqrt(np.mean([np.trace(one.covariance) / 2.0 for one in found])) / ARCSEC_RAD
    share = np.mean([one.jackknife_used for one in found])
    return [
        f"{rms:.2f}",
        f"{stated:.2f}",
        f"{chi2.mean():.2f}",
        f"{inside:.3f} ± {error:.3f}",
        f"{share:.2f}",
        refused,
    ]
