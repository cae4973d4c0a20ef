"""Of a large scan a sample is registered: its poses must scatter about the truth as their covariance says."""

from dataclasses import replace
from typing import Final

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.registration import Registration, planar, register_stations
from tasks.simulation import SimulatedCampaignRequest, SimulatedStation
from tests.unit.registration.conftest import HINT, simulated, stated_scan, succeed
from tests.unit.registration.courtyard import SIGMAS

STATIONS: Final = 5
POINTS: Final = 240_000
ONE_IN: Final = 6
SITES: Final = 12


def pose_errors(stations: tuple[SimulatedStation, ...], registration: Registration) -> NDArray[np.float64]:
    """Found minus true (n, 6)."""
    true = [station.setup for station in stations]
    pairs = list(zip(registration.poses, true, strict=True))
    turns = [
        Rotation.from_matrix(found.rotation @ setup.rotation_site_scanner.T).as_rotvec()
        for found, setup in pairs
    ]
    return np.hstack([turns, [found.position_m - setup.position_m for found, setup in pairs]])


def in_sigmas(
    errors: NDArray[np.float64], covariance: NDArray[np.float64], take: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Errors (n, 6) of combinations (n, n) of stations in units of their stated sigmas."""
    blocks = [covariance[k::SIX, k::SIX] for k in range(SIX)]
    sigmas = np.array([np.sqrt(np.diag(take @ block @ take.T)) for block in blocks]).T
    return np.asarray((take @ errors) / sigmas)


def rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.mark.slow
def test_poses_of_a_sample_scatter_as_their_covariance_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planar, "MOST_POINTS", POINTS // ONE_IN)
    request = SimulatedCampaignRequest(stations=STATIONS, points=POINTS)
    relative = np.eye(STATIONS) - 1.0 / STATIONS
    each, apart, jointly = [], [], []
    for seed in range(7000, 7000 + SITES):
        stations = simulated(replace(request, seed=seed))
        scans = [stated_scan(station) for station in stations]
        found = succeed(register_stations(scans, SIGMAS, hint=HINT))
        errors = pose_errors(stations, found)
        each.append(in_sigmas(errors, found.covariance, np.eye(STATIONS)))
        apart.append(in_sigmas(errors, found.covariance, relative))
        jointly.append(errors.ravel() @ np.linalg.solve(found.covariance, errors.ravel()) / errors.size)
    # 12 sites of 30 parameters; what a site shares makes them fewer: 0.1 is a standard deviation of the joint figure
    assert 0.7 < np.sqrt(np.mean(jointly)) < 1.2
    for part in (np.array(each), np.array(apart)):
        for k in range(SIX):
            assert 0.5 < rms(part[:, :, k]) < 1.5
