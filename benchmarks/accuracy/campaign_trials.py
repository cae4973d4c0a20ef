"""Leans of drawn campaigns by schemes and methods, with everything that is stated of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.known_campaign import CAMPAIGNS, draw_campaign
from benchmarks.accuracy.sliced_shaft import LEAN
from benchmarks.accuracy.trials import rng_of, run_trials
from tasks.geometry.failure import FitFailure
from tasks.methods import method_of
from tasks.scheme_lean import lean_of_scheme
from tasks.slicing import SCHEMES

WAYS: Final = ("S/surface", "A/robust", "B/robust", "E/robust", "A/paper")


@dataclass(frozen=True, slots=True, eq=False)
class Stated:
    """Error (2,) of a lean and its covariances (2, 2): as stated, of the points alone, by bootstrap."""

    error: NDArray[np.float64]
    covariance: NDArray[np.float64]
    points: NDArray[np.float64]
    bootstrap: NDArray[np.float64] | None
    jackknife_used: bool

    @property
    def chi2(self) -> float:
        """Error under the stated covariance: 2 on average where that is true."""
        return float(self.error @ np.linalg.solve(self.covariance, self.error))


Outcome = Stated | FitFailure


def outcomes_of(
    campaign: str, ways: Sequence[str], n: int, processes: int, seed: int
) -> Mapping[str, Sequence[Outcome]]:
    """What became of n campaigns, by scheme and method."""
    trials = run_trials(partial(_trial, campaign, tuple(ways), seed), n, processes)
    return {way: [trial[way] for trial in trials] for way in ways}


def _trial(name: str, ways: Sequence[str], seed: int, number: int) -> dict[str, Outcome]:
    campaign = CAMPAIGNS[name]
    shaft = draw_campaign(campaign, rng_of(seed, number))
    outcomes: dict[str, Outcome] = {}
    for way in ways:
        scheme_name, method_name = way.split("/")
        scheme = SCHEMES[scheme_name]
        lean = lean_of_scheme(shaft, scheme, method_of(scheme, method_name))
        if isinstance(lean, FitFailure):
            outcomes[way] = lean
            continue
        outcomes[way] = Stated(
            lean.lean - LEAN,
            lean.covariance,
            lean.point_covariance,
            lean.bootstrap,
            lean.source == "jackknife",
        )
    return outcomes
