"""A simulated structure of any kind, from its scans to its lean, in memory: no Prefect, no files; not a test."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tasks.epoch_shaft import EpochShaft, isolate_epoch
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.methods import method_of, suited_to
from tasks.preprocessing import ShaftOptions, StructurePrior
from tasks.registration import (
    InstrumentSigmas,
    ShaftHint,
    StationScan,
    Ties,
    register_stations,
)
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.simulation import SimulatedCampaignRequest, SimulatedStation, scan_epochs
from tasks.slicing import SCHEMES


@dataclass(frozen=True, slots=True)
class MeasuredKind:
    """An epoch of a structure: its true lean (2,), its shaft, and the leans of the whole surface and of slices."""

    truth: NDArray[np.float64]
    shaft: EpochShaft
    whole: Lean
    sliced: Lean


def measured_epochs(request: SimulatedCampaignRequest) -> Iterator[MeasuredKind]:
    """Measure the epochs of a simulated campaign, every station used."""
    for epoch, stations in scan_epochs(request):
        yield _measured(request, epoch.truth.lean.as_array(), tuple(stations))


def chi2_of(error: NDArray[np.float64], covariance: NDArray[np.float64]) -> float:
    """Chi-square, 2 degrees of freedom, of an error (2,) under a covariance (2, 2)."""
    return float(error @ np.linalg.solve(covariance, error))


def prior_of(request: SimulatedCampaignRequest) -> StructurePrior:
    """What the campaign file of a simulation states of the structure."""
    low, high = (float(f"{radius:.2g}") for radius in request.radius_m)
    return StructurePrior(request.kind, request.shaft_z_m, (0.0, 0.0), (low, high))


def _measured(
    request: SimulatedCampaignRequest, truth: NDArray[np.float64], stations: tuple[SimulatedStation, ...]
) -> MeasuredKind:
    scans = [
        StationScan(s.setup.station, s.scan.points_m, s.setup.stated_position_m, s.setup.stated_heading_rad)
        for s in stations
    ]
    prior, scanner = prior_of(request), request.scanner
    sigmas = InstrumentSigmas(
        (scanner.position_sigma_m, scanner.height_sigma_m),
        float(np.radians(scanner.heading_sigma_deg)),
        float(np.radians(scanner.level_sigma_deg)),
    )
    ties: Ties = "none" if request.kind == "square-tower" else "common shaft"
    hint = ShaftHint(prior.base_xy_m, prior.shaft_z_m, prior.radius_m, ties)
    registration = register_stations(scans, sigmas, hint)
    assert not isinstance(registration, FitFailure), registration
    assert not registration.refused, registration.refused
    shaft = isolate_epoch([scan.points_m for scan in scans], registration, prior, ShaftOptions())
    assert not isinstance(shaft, FitFailure), shaft
    isolated = IsolatedShaft(shaft.cloud, shaft.model, registration, prior.shaft_z_m)
    return MeasuredKind(
        truth, shaft, _lean(isolated, prior, "S", "surface"), _lean(isolated, prior, "A", "robust")
    )


def _lean(isolated: IsolatedShaft, prior: StructurePrior, scheme: str, method: str) -> Lean:
    cut = suited_to(SCHEMES[scheme], prior.kind)
    found = lean_of_scheme(isolated, cut, method_of(cut, method))
    assert isinstance(found, Lean), found
    return found
