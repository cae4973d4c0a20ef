"""Does the lean scatter as its covariance says: simulated epochs, the whole chain in memory, one row a scheme and method.

    .venv/bin/python benchmarks/monte_carlo.py [--seeds 30] [--stations 8] [--points 40000]

Every seed is a new site, new stations, new errors of GNSS, heading, level, range and angle. Chi-square is of found minus
true under the stated covariance: 2 on average and below 5.99 in 95 of 100 where the covariance is true.
"""

import argparse
from collections import defaultdict
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD
from tasks.epoch_shaft import EpochShaft, isolate_epoch
from tasks.geometry.failure import FitFailure
from tasks.geometry.plane_vectors import CHI2_95
from tasks.lean import Lean
from tasks.level_check import worst_suspect
from tasks.methods import methods_of
from tasks.preprocessing import ShaftOptions, StructurePrior
from tasks.registration import InstrumentSigmas, Registration, ShaftHint, StationScan, register_stations
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.simulation import Scanner, SimulatedCampaignRequest, SimulatedStation, scan_epochs
from tasks.slicing import SCHEMES

SHAFT_LOW_M = 2.0


def main() -> None:
    """Run the seeds and print the table."""
    wanted = argparse.ArgumentParser()
    wanted.add_argument("--seeds", type=int, default=30)
    wanted.add_argument("--stations", type=int, default=8)
    wanted.add_argument("--points", type=int, default=40_000)
    asked = wanted.parse_args()
    found: dict[str, list[tuple[NDArray[np.float64], Lean]]] = defaultdict(list)
    suspects = 0
    for seed in range(1000, 1000 + asked.seeds):
        request = SimulatedCampaignRequest(epochs=1, stations=asked.stations, points=asked.points, seed=seed)
        epoch, stations = next(iter(scan_epochs(request)))
        registration, shaft = measure(request, tuple(stations))
        suspects += sum(d.state != "ok" for d in registration.diagnoses) + len(registration.refused)
        suspects += worst_suspect(shaft.levels) is not None
        truth = np.array([epoch.truth.lean.east, epoch.truth.lean.north])
        for label, lean in leans(request, registration, shaft):
            found[label].append((truth, lean))
    print(
        f"{asked.seeds} seeds, {asked.stations} stations of {asked.points} points; false suspects: {suspects}"
    )
    print('scheme/method     n   bias E, N (")       rms (")  sigma (")  chi2 mean  in 95 %')
    for label, pairs in found.items():
        print(f"{label:14s} {line(pairs)}")


def measure(
    request: SimulatedCampaignRequest, stations: tuple[SimulatedStation, ...]
) -> tuple[Registration, EpochShaft]:
    """Register the stations as they state themselves, and isolate the shaft."""
    scans = [
        StationScan(s.setup.station, s.scan.points_m, s.setup.stated_position_m, s.setup.stated_heading_rad)
        for s in stations
    ]
    prior = prior_of(request)
    hint = ShaftHint(prior.base_xy_m, prior.shaft_z_m, prior.radius_m)
    registration = register_stations(scans, sigmas_of(request.scanner), hint)
    if isinstance(registration, FitFailure):
        raise SystemExit(f"seed {request.seed}: {registration.reason}")
    shaft = isolate_epoch([scan.points_m for scan in scans], registration, prior, ShaftOptions())
    if isinstance(shaft, FitFailure):
        raise SystemExit(f"seed {request.seed}: {shaft.reason}")
    return registration, shaft


def leans(
    request: SimulatedCampaignRequest, registration: Registration, shaft: EpochShaft
) -> Iterator[tuple[str, Lean]]:
    """Measure the lean of every scheme and method that gives one."""
    isolated = IsolatedShaft(shaft.cloud, shaft.model, registration, prior_of(request).shaft_z_m)
    for scheme in SCHEMES.values():
        for method in methods_of(scheme):
            lean = lean_of_scheme(isolated, scheme, method)
            if not isinstance(lean, FitFailure):
                yield f"{scheme.name}/{method.name}", lean


def sigmas_of(scanner: Scanner) -> InstrumentSigmas:
    """What a campaign file would state of the simulated scanner."""
    return InstrumentSigmas(
        (scanner.position_sigma_m, scanner.height_sigma_m),
        float(np.radians(scanner.heading_sigma_deg)),
        float(np.radians(scanner.level_sigma_deg)),
    )


def prior_of(request: SimulatedCampaignRequest) -> StructurePrior:
    """What a campaign file would state of the simulated shaft."""
    ends = np.array([SHAFT_LOW_M, request.shaft_top_m])
    low, high = (round(float(radius), 1) for radius in request.shape.radius_at(ends))
    return StructurePrior("chimney", (SHAFT_LOW_M, request.shaft_top_m), (0.0, 0.0), (low, high))


def line(pairs: list[tuple[NDArray[np.float64], Lean]]) -> str:
    """Summarise found against true."""
    error = np.array([lean.lean - truth for truth, lean in pairs])
    chi2 = np.array(
        [e @ np.linalg.solve(lean.covariance, e) for e, (_, lean) in zip(error, pairs, strict=True)]
    )
    stated = np.sqrt(np.mean([np.trace(lean.covariance) / 2 for _, lean in pairs])) / ARCSEC_RAD
    east, north = error.mean(axis=0) / ARCSEC_RAD
    rms = np.sqrt(np.mean(error**2)) / ARCSEC_RAD
    inside = np.mean(chi2 < CHI2_95)
    return f"{len(pairs):5d}  {east:+7.2f} {north:+7.2f}   {rms:9.2f}  {stated:9.2f}  {chi2.mean():9.2f}  {inside:7.2f}"


if __name__ == "__main__":
    main()
