"""Awkward campaigns: what registration says of them, and what becomes of the lean.

    .venv/bin/python -m benchmarks.registration scenarios [--seeds 1] [--points 60000] [--only "5 deg,swapped"]

One row a case and campaign: stations used, those left out and those called suspect; of the stations that ought to be
named how many are (suspect, refused or started anew), and how many others are named without cause; the lean vector
against the truth and against true poses of the same scans, its stated sigma (one component) and its chi-square:
below 13.8 in 999 of 1000 where the covariance is true. The reasons follow.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.registration.known import KnownEpoch
from benchmarks.registration.outcome import Outcome, evaluate, moved
from benchmarks.registration.scenario_cases import CASES, Case
from benchmarks.registration.simulated import simulated_epoch
from tasks.conventions import ARCSEC_RAD
from tasks.open3d_import import import_open3d
from tasks.simulation import SimulatedCampaignRequest

STATIONS: Final = 8
CHI2_999: Final = 13.8
AS_STATED: Final = "as stated"
HEADER: Final = (
    "case                    seed  used  out  suspect  named  others  "
    'error (")  moved (")  sigma (")    chi2  verdict   heading (")  time (s)'
)


@dataclass(frozen=True, slots=True)
class Named:
    """Names of stations that registration does not take as they are."""

    refused: frozenset[str]
    suspect: frozenset[str]
    started_anew: frozenset[str]

    @property
    def any(self) -> frozenset[str]:
        """Named in one way or another."""
        return self.refused | self.suspect | self.started_anew


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table, case by case."""
    wanted = argparse.ArgumentParser(
        prog="scenarios", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    wanted.add_argument("--seeds", type=int, default=1)
    wanted.add_argument("--first-seed", type=int, default=2000)
    wanted.add_argument("--points", type=int, default=60_000, help="of each station")
    wanted.add_argument("--only", default="", help="comma list of parts of the names of cases")
    wanted.add_argument("--cache", type=Path, help="folder that keeps the simulated scans")
    asked = wanted.parse_args(arguments)
    import_open3d()  # so that its loading is in nobody's time
    wanted_parts = asked.only.split(",")
    print(HEADER)
    for name, case in CASES.items():
        if any(part.strip() in name for part in wanted_parts):
            for seed in range(asked.first_seed, asked.first_seed + asked.seeds):
                _print_case(name, case, seed, asked)


def _print_case(name: str, case: Case, seed: int, asked: argparse.Namespace) -> None:
    request = SimulatedCampaignRequest(
        epochs=1, stations=STATIONS, points=asked.points, seed=seed, surroundings=case.surroundings
    )
    epoch = case.change(simulated_epoch(request, asked.cache, case.surfaces))
    ours = evaluate(epoch, "ours")
    floor = evaluate(_used(epoch, ours), "true")
    culprits = frozenset(f"ST{row + 1:02d}" for row in case.culprits)
    print(f"{name:23s} {seed:5d} {_row(epoch, ours, floor, culprits)}", flush=True)
    for reason in _reasons(ours):
        print(f"    {reason}")


def _used(epoch: KnownEpoch, ours: Outcome) -> KnownEpoch:
    """Only the stations that ours uses, so that true poses have the same view of the shaft."""
    if ours.registration is None:
        return epoch
    return epoch.with_stations([epoch.station(pose.station) for pose in ours.registration.poses])


def _row(epoch: KnownEpoch, ours: Outcome, floor: Outcome, culprits: frozenset[str]) -> str:
    named = _named(ours)
    used = 0 if ours.registration is None else len(ours.registration.poses)
    found = f"{len(culprits & named.any)}/{len(culprits)}" if culprits else "-"
    others = len(named.any - culprits)
    counts = f"{used:5d} {len(epoch.stations) - used:4d} {len(named.suspect):8d} {found:>6s} {others:7d}"
    if ours.lean is None:
        return f"{counts}  refused: {ours.failure}"
    error, away = (_length(vector) for vector in (ours.error, moved(ours, floor)))
    heading = 0.0 if ours.poses is None else ours.poses.heading_rms_arcsec
    chi2 = ours.chi2 or 0.0
    verdict = "covered" if chi2 < CHI2_999 else "WRONG"
    return (
        f"{counts} {error:10.2f} {away:10.2f} {ours.sigma_arcsec:10.2f} {chi2:7.1f}  {verdict:8s} "
        f"{heading:11.1f} {ours.seconds:9.2f}"
    )


def _length(vector: object) -> float:
    return float(np.linalg.norm(vector)) / ARCSEC_RAD if isinstance(vector, np.ndarray) else float("nan")


def _named(outcome: Outcome) -> Named:
    registration = outcome.registration
    if registration is None:
        return Named(frozenset(), frozenset(), frozenset())
    return Named(
        frozenset(station.station for station in registration.refused),
        frozenset(d.station for d in registration.diagnoses if d.state != "ok"),
        frozenset(d.station for d in registration.diagnoses if d.start != AS_STATED),
    )


def _reasons(outcome: Outcome) -> Iterator[str]:
    yield from outcome.notes
    if outcome.registration is not None:
        for diagnosis in outcome.registration.diagnoses:
            if diagnosis.start != AS_STATED:
                yield f"{diagnosis.station} start: {diagnosis.start}"
