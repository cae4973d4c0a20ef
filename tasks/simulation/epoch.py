"""One epoch: the scene as it stands then, the stations as they are set up then, and their scans."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.simulation.raycasting import RayScene, build_scene
from tasks.simulation.scan import SimulatedScan, scan_windows, simulate_station
from tasks.simulation.scanner import Scanner
from tasks.simulation.shape import ShaftShape
from tasks.simulation.site import Site
from tasks.simulation.station import Setup, set_up_station
from tasks.simulation.structure import Fittings, structure_meshes

_NEW_PLACE_M: Final = 4.0
"""A station is set up again within that distance east and north of its usual place."""


@dataclass(frozen=True, slots=True)
class SimulatedStation:
    """A set-up and its scan."""

    setup: Setup
    scan: SimulatedScan


def epoch_scene(site: Site, shape: ShaftShape, fittings: Fittings | None = None) -> RayScene:
    """Build the scene of an epoch: the site as always, the structure as it stands now."""
    return build_scene(
        [
            *structure_meshes(shape, fittings or Fittings()),
            *((s, m) for s, m in site.meshes if len(m.triangles)),
        ]
    )


def set_up_epoch(
    site: Site, places_m: NDArray[np.float64], scanner: Scanner, rng: np.random.Generator
) -> tuple[Setup, ...]:
    """Set up stations ST01, ST02, ... near their usual places (n, 2)."""
    return tuple(
        set_up_station(
            f"ST{index + 1:02d}",
            place_m + rng.uniform(-_NEW_PLACE_M, _NEW_PLACE_M, 2),
            site.terrain,
            scanner,
            rng,
        )
        for index, place_m in enumerate(places_m)
    )


def simulate_epoch(
    scene: RayScene,
    shape: ShaftShape,
    setups: tuple[Setup, ...],
    scanner: Scanner,
    n_points: int,
    rng: np.random.Generator,
) -> Iterator[SimulatedStation]:
    """Scan from every set-up in turn, ``n_points`` each; station by station, so that one fits in memory."""
    for setup, station_rng in zip(setups, rng.spawn(len(setups)), strict=True):
        windows = scan_windows(setup, shape)
        yield SimulatedStation(setup, simulate_station(scene, setup, windows, scanner, n_points, station_rng))
