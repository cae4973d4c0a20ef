"""One small site that the tests of the simulation share."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.simulation import (
    PERFECT_SCANNER,
    RayScene,
    ShaftShape,
    SimulatedStation,
    Site,
    build_site,
    draw_station_places,
    epoch_scene,
    set_up_epoch,
    simulate_epoch,
)


@dataclass(frozen=True, slots=True)
class SmallCampaign:
    places_m: NDArray[np.float64]
    site: Site
    shape: ShaftShape
    scene: RayScene
    perfect: tuple[SimulatedStation, ...]
    """Scans of a scanner without errors."""


@pytest.fixture(scope="package")
def small() -> SmallCampaign:
    rng = np.random.default_rng(5)
    places_m = draw_station_places(6, rng)
    site = build_site(places_m, rng)
    shape = ShaftShape()
    scene = epoch_scene(site, shape)
    setups = set_up_epoch(site, places_m, PERFECT_SCANNER, rng)
    scans = simulate_epoch(scene, shape, setups, PERFECT_SCANNER, 40_000, rng)
    return SmallCampaign(places_m, site, shape, scene, tuple(scans))
