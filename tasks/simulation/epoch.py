"""One epoch: the scene as it stands then, the stations as they are set up then, and their scans."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tasks.simulation.attachments import Attachments, attachment_meshes
from tasks.simulation.layout import Layout
from tasks.simulation.raycasting import RayScene, build_scene
from tasks.simulation.scan import SimulatedScan, scan_windows, simulate_station
from tasks.simulation.scanner import Scanner
from tasks.simulation.shape import ShaftShape
from tasks.simulation.site import Site
from tasks.simulation.station import Setup, set_up_station
from tasks.simulation.structure import Fittings, structure_meshes
from tasks.simulation.wall import Wall


@dataclass(frozen=True, slots=True)
class Body:
    """What the structure is made of besides its shape; None is the plain shaft of a chimney, with nothing more on it."""

    fittings: Fittings = field(default_factory=Fittings)
    wall: Wall | None = None
    attachments: Attachments | None = None


@dataclass(frozen=True, slots=True)
class SimulatedStation:
    """A set-up and its scan."""

    setup: Setup
    scan: SimulatedScan


def epoch_scene(site: Site, shape: ShaftShape, body: Body | None = None) -> RayScene:
    """Build the scene of an epoch: the site as always, the structure as it stands now."""
    made = Body() if body is None else body
    attached = made.attachments
    return build_scene(
        [
            *structure_meshes(shape, made.fittings, made.wall),
            *(() if attached is None else attachment_meshes(shape, made.fittings, attached)),
            *((s, m) for s, m in site.meshes if len(m.triangles)),
        ]
    )


def set_up_epoch(
    site: Site,
    places_m: NDArray[np.float64],
    scanner: Scanner,
    rng: np.random.Generator,
    layout: Layout | None = None,
) -> tuple[Setup, ...]:
    """Set up stations ST01, ST02, ... near their usual places (n, 2)."""
    known = layout or Layout()
    near_m = known.new_place_m
    return tuple(
        set_up_station(
            f"ST{index + 1:02d}",
            place_m + rng.uniform(-near_m, near_m, 2),
            site.terrain,
            scanner,
            rng,
            known.margin_m,
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
