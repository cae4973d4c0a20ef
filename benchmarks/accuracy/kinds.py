"""Every kind of structure simulated from its scans to its lean, the whole chain in memory: one row a kind and method.

    .venv/bin/python -m benchmarks.accuracy kinds [--seeds 10] [--stations 5] [--points 30000] [--kind NAME]...

Every seed is a new site, new stations, new errors of GNSS, heading, level, range and angle, and a new rough wall.
"""

import argparse
from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.markdown import print_table
from tasks.conventions import ARCSEC_RAD
from tasks.epoch_shaft import isolate_epoch
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.methods import method_of, suited_to
from tasks.preprocessing import ShaftOptions, StructurePrior
from tasks.registration import InstrumentSigmas, ShaftHint, StationScan, Ties, register_stations
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.simulation import Scanner, SimulatedCampaignRequest, SimulatedStation, scan_epochs
from tasks.simulation.kinds import CASES, request_of_kind
from tasks.slicing import SCHEMES

WAYS = (("S", "surface"), ("A", "robust"))

Pairs = list[tuple[NDArray[np.float64], Lean]]


def main(arguments: Sequence[str]) -> None:
    """Run the seeds and print the table."""
    wanted = argparse.ArgumentParser(prog="kinds", description=__doc__)
    wanted.add_argument("--seeds", type=int, default=10)
    wanted.add_argument("--stations", type=int, default=5)
    wanted.add_argument("--points", type=int, default=30_000)
    wanted.add_argument("--kind", action="append", choices=sorted(CASES))
    asked = wanted.parse_args(arguments)
    rows = []
    for kind in asked.kind or sorted(CASES):
        found: dict[str, Pairs] = defaultdict(list)
        lost = 0
        for seed in range(100, 100 + asked.seeds):
            request = request_of_kind(kind, 1, asked.stations, asked.points, seed)
            lost += _measure(request, found)
        rows += [[kind, way, str(lost), *_cells(pairs, request)] for way, pairs in found.items()]
    print_table(
        [
            "kind",
            "by",
            "stations lost",
            "n",
            'rms (")',
            "rms at H (mm)",
            'sigma (")',
            "chi-square",
            "in 95 %",
        ],
        rows,
    )


def _measure(request: SimulatedCampaignRequest, found: dict[str, Pairs]) -> int:
    """Add what one epoch gave, and say how many stations registration left out."""
    epoch, stations = next(iter(scan_epochs(request)))
    shaft = _isolated(request, tuple(stations))
    if isinstance(shaft, FitFailure):
        print(f"{request.kind}, seed {request.seed}: {shaft.reason}")
        return request.stations
    for label, lean in _leans(request.kind, shaft):
        found[label].append((epoch.truth.lean.as_array(), lean))
    return request.stations - len(shaft.registration.poses)


def _isolated(
    request: SimulatedCampaignRequest, stations: tuple[SimulatedStation, ...]
) -> IsolatedShaft | FitFailure:
    """Register the stations as they state themselves, and isolate the structure."""
    scans = [
        StationScan(s.setup.station, s.scan.points_m, s.setup.stated_position_m, s.setup.stated_heading_rad)
        for s in stations
    ]
    low, high = (float(f"{radius:.2g}") for radius in request.radius_m)
    prior = StructurePrior(request.kind, request.shaft_z_m, (0.0, 0.0), (low, high))
    ties: Ties = "none" if request.kind == "square-tower" else "common shaft"
    hint = ShaftHint(prior.base_xy_m, prior.shaft_z_m, prior.radius_m, ties)
    registration = register_stations(scans, _sigmas(request.scanner), hint)
    if isinstance(registration, FitFailure):
        return registration
    refused = {station.station for station in registration.refused}
    clouds = [scan.points_m for scan in scans if scan.station not in refused]
    shaft = isolate_epoch(clouds, registration, prior, ShaftOptions())
    if isinstance(shaft, FitFailure):
        return shaft
    return IsolatedShaft(shaft.cloud, shaft.model, registration, prior.shaft_z_m)


def _leans(kind: str, shaft: IsolatedShaft) -> Iterator[tuple[str, Lean]]:
    for scheme, method in WAYS:
        cut = suited_to(SCHEMES[scheme], kind)
        lean = lean_of_scheme(shaft, cut, method_of(cut, method))
        if not isinstance(lean, FitFailure):
            yield f"{scheme}/{method}", lean


def _sigmas(scanner: Scanner) -> InstrumentSigmas:
    return InstrumentSigmas(
        (scanner.position_sigma_m, scanner.height_sigma_m),
        float(np.radians(scanner.heading_sigma_deg)),
        float(np.radians(scanner.level_sigma_deg)),
    )


def _cells(pairs: Pairs, request: SimulatedCampaignRequest) -> list[str]:
    error = np.array([lean.lean - truth for truth, lean in pairs])
    chi2 = np.array(
        [e @ np.linalg.solve(lean.covariance, e) for e, (_, lean) in zip(error, pairs, strict=True)]
    )
    rms = float(np.sqrt(np.mean(error**2)))
    sigma = float(np.median([np.sqrt(np.trace(lean.covariance) / 2.0) for _, lean in pairs]))
    return [
        str(len(pairs)),
        f"{rms / ARCSEC_RAD:.2f}",
        f"{1e3 * rms * request.shaft_top_m:.2f}",
        f"{sigma / ARCSEC_RAD:.2f}",
        f"{chi2.mean():.2f}",
        f"{np.mean(chi2 < 5.991):.2f}",
    ]
