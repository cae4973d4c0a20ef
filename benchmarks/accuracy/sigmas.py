"""Stated sigma of the points, its bootstrap, and how much the lean scatters, where the poses are exact.

.venv/bin/python -m benchmarks.accuracy sigmas [--trials 500] [--campaigns noise,rough,oval]
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.accuracy.campaign_trials import Outcome, Stated, outcomes_of
from benchmarks.accuracy.coverage import asked_of
from benchmarks.accuracy.known_campaign import CAMPAIGNS, NOTHING
from benchmarks.accuracy.markdown import print_table
from tasks.conventions import ARCSEC_RAD


def main(arguments: Sequence[str]) -> None:
    """Print one row for every campaign with exact poses, scheme and method."""
    asked = asked_of("sigmas", __doc__, arguments)
    rows = []
    for name in asked.campaigns.split(","):
        if CAMPAIGNS[name].drawn != NOTHING:
            continue
        ways = asked.ways.split(",")
        for way, outcomes in outcomes_of(name, ways, asked.trials, asked.processes, asked.seed).items():
            rows.append([CAMPAIGNS[name].title, way, *_cells(outcomes)])
    print(f"Sigma of one component of the lean, {asked.trials} trials\n")
    head = [
        "campaigns",
        "by",
        'truth (")',
        'points (")',
        'bootstrap (")',
        "points / truth",
        "bootstrap / truth",
    ]
    print_table(head, rows)


def _cells(outcomes: Sequence[Outcome]) -> list[str]:
    found = [outcome for outcome in outcomes if isinstance(outcome, Stated)]
    if not found:
        return ["-"] * 5
    truth = np.sqrt(np.mean([one.error @ one.error / 2.0 for one in found])) / ARCSEC_RAD
    points = np.sqrt(np.mean([np.trace(one.points) / 2.0 for one in found])) / ARCSEC_RAD
    resampled = [np.trace(one.bootstrap) / 2.0 for one in found if one.bootstrap is not None]
    if not resampled:
        return [f"{truth:.2f}", f"{points:.2f}", "none", f"{points / truth:.2f}", "-"]
    bootstrap = np.sqrt(np.mean(resampled)) / ARCSEC_RAD
    return [
        f"{truth:.2f}",
        f"{points:.2f}",
        f"{bootstrap:.2f}",
        f"{points / truth:.2f}",
        f"{bootstrap / truth:.2f}",
    ]
