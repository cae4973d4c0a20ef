from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.registration import InstrumentSigmas, Registration, StationScan, register_stations
from tasks.simulation import SimulatedCampaignRequest, SimulatedStation, scan_epochs

SIGMAS = InstrumentSigmas((0.015, 0.0225), float(np.radians(0.15)), float(np.radians(0.0008)))


@dataclass(frozen=True)
class Site:
    stations: tuple[SimulatedStation, ...]
    scans: tuple[StationScan, ...]


def stated_scan(station: SimulatedStation) -> StationScan:
    setup = station.setup
    return StationScan(
        setup.station, station.scan.points_m, setup.stated_position_m, setup.stated_heading_rad
    )


@pytest.fixture(scope="session")
def site() -> Site:
    request = SimulatedCampaignRequest(epochs=1, stations=5, points=40_000, seed=3)
    _, stations = next(iter(scan_epochs(request)))
    seen = tuple(stations)
    return Site(seen, tuple(stated_scan(station) for station in seen))


@pytest.fixture(scope="session")
def registration(site: Site) -> Registration:
    return register_stations(site.scans, SIGMAS)


def bare_cylinder(rng: np.random.Generator, n: int = 40_000) -> NDArray[np.float64]:
    """A round shaft and nothing else, around (0, 0), 60 m tall, radius 4 m."""
    angle, height = rng.uniform(0, 2 * np.pi, n), rng.uniform(0, 60, n)
    return np.column_stack([4 * np.cos(angle), 4 * np.sin(angle), height])
