from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.registration import Registration, ShaftHint, StationScan, register_stations
from tasks.registration.planar import ScanPlanes, scan_planes
from tasks.simulation import SimulatedCampaignRequest, SimulatedStation, scan_epochs
from tests.unit.registration.courtyard import SIGMAS, Courtyard, draw_courtyard

HINT = ShaftHint((0.0, 0.0), (2.0, 100.0), (4.6, 2.7))
"""What a campaign file says of the simulated shaft."""


@dataclass(frozen=True)
class Site:
    stations: tuple[SimulatedStation, ...]
    scans: tuple[StationScan, ...]


@dataclass(frozen=True)
class SeenSite:
    """A site with its planes, so that a start can be looked for without finding them again."""

    stations: tuple[SimulatedStation, ...]
    scans: tuple[StationScan, ...]
    planes: tuple[ScanPlanes, ...]

    def with_scan(self, i: int, scan: StationScan) -> list[StationScan]:
        return [scan if k == i else other for k, other in enumerate(self.scans)]


def stated_scan(station: SimulatedStation) -> StationScan:
    setup = station.setup
    return StationScan(
        setup.station, station.scan.points_m, setup.stated_position_m, setup.stated_heading_rad
    )


def succeed(registration: Registration | FitFailure) -> Registration:
    assert isinstance(registration, Registration), registration
    return registration


def simulated(request: SimulatedCampaignRequest) -> tuple[SimulatedStation, ...]:
    _, stations = next(iter(scan_epochs(replace(request, epochs=1))))
    return tuple(stations)


@pytest.fixture(scope="session")
def site() -> Site:
    seen = simulated(SimulatedCampaignRequest(stations=5, points=40_000, seed=3))
    return Site(seen, tuple(stated_scan(station) for station in seen))


@pytest.fixture(scope="session")
def registration(site: Site) -> Registration:
    return succeed(register_stations(site.scans, SIGMAS))


@pytest.fixture(scope="session")
def eight() -> SeenSite:
    """Enough of them, and enough points, that a lost station can be placed by what stands around."""
    seen = simulated(SimulatedCampaignRequest(stations=8, points=60_000, seed=3))
    scans = tuple(stated_scan(station) for station in seen)
    return SeenSite(seen, scans, tuple(scan_planes([scan.points_m for scan in scans])))


@pytest.fixture(scope="session")
def yard() -> Courtyard:
    return draw_courtyard(1)


def bare_cylinder(rng: np.random.Generator, n: int = 40_000) -> NDArray[np.float64]:
    """A round shaft and nothing else, around (0, 0), 60 m tall, radius 4 m."""
    angle, height = rng.uniform(0, 2 * np.pi, n), rng.uniform(0, 60, n)
    return np.column_stack([4 * np.cos(angle), 4 * np.sin(angle), height])
