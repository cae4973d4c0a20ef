"""A campaign as an idea: what is asked for, and what each epoch of it is before anything is scanned."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import datetime, timedelta, timezone
from typing import Final

import numpy as np

from storage.errors import UsageError
from tasks.simulation.attachments import Attachments
from tasks.simulation.epoch import Body, SimulatedStation, epoch_scene, set_up_epoch, simulate_epoch
from tasks.simulation.layout import Layout
from tasks.simulation.movement import Movement
from tasks.simulation.scanner import Scanner
from tasks.simulation.shape import AxisTruth, Horizontal, ShaftShape, axis_truth
from tasks.simulation.site import Surroundings, build_site
from tasks.simulation.station import draw_station_places
from tasks.simulation.structure import Fittings
from tasks.simulation.wall import Wall

REFERENCE_SIGMA: Final = 5e-5
"""Standard deviation of each component of the total station's lean vector."""

_MONTHS_APART: Final = 3


@dataclass(frozen=True, slots=True)
class SimulatedCampaignRequest:
    """What to simulate; the same request gives the same bytes.

    ``points`` is a station's. ``shape`` is that of the first epoch, ``movement`` what the later ones add. ``limits`` are
    names of shipped tables, the first one counts. A chimney as in the paper is the default; ``tasks.simulation.kinds``
    has the other kinds.
    """

    epochs: int = 4
    stations: int = 8
    points: int = 200_000
    seed: int = 1
    shape: ShaftShape = field(default_factory=ShaftShape)
    movement: Movement = field(default_factory=Movement)
    scanner: Scanner = field(default_factory=Scanner)
    fittings: Fittings = field(default_factory=Fittings)
    surroundings: Surroundings = field(default_factory=Surroundings)
    kind: str = "chimney"
    limits: tuple[str, ...] = ("gb50078-concrete-quoted",)
    layout: Layout = field(default_factory=Layout)
    wall: Wall | None = None
    attachments: Attachments | None = None

    def __post_init__(self) -> None:
        if min(self.epochs, self.stations, self.points) < 1 or self.seed < 0:
            raise UsageError(
                "a simulated campaign needs at least 1 epoch, 1 station and 1 point, and a seed >= 0; got "
                f"{self.epochs}, {self.stations}, {self.points} and seed {self.seed}"
            )

    @property
    def shaft_top_m(self) -> float:
        """Upper end of the part that is sliced: just below the platform, or the top where there is none."""
        return round(min(self.fittings.platform_z_m, self.shape.height_m) - self.layout.below_top_m, 3)

    @property
    def shaft_z_m(self) -> tuple[float, float]:
        """Lower and upper end of the part that is sliced."""
        return self.layout.shaft_foot_m, self.shaft_top_m

    @property
    def radius_m(self) -> tuple[float, float]:
        """Mean radius (of a square wall: half the side) at the two ends of the part that is sliced."""
        ends_m = np.array(self.shaft_z_m)
        added_m = np.zeros(2) if self.wall is None else self.wall.added_at(ends_m)
        low, high = (self.shape.radius_at(ends_m) + added_m).tolist()
        return low, high


@dataclass(frozen=True, slots=True)
class SimulatedEpoch:
    """What is known of an epoch before its scans: its shape, the truth, and a total station's lean vector."""

    index: int
    shape: ShaftShape
    truth: AxisTruth
    reference: Horizontal

    @property
    def name(self) -> str:
        """Id of the epoch: year and month."""
        return epoch_name(self.index)

    @property
    def time(self) -> datetime:
        """When it was measured."""
        return epoch_time(self.index)


def epoch_name(index: int) -> str:
    """Id of epoch ``index``, 0 for the first."""
    return f"{epoch_time(index):%Y-%m}"


def epoch_time(index: int) -> datetime:
    """Six in the morning, before the sun bends the shaft; every three months from January 2025."""
    months = _MONTHS_APART * index
    return datetime(2025 + months // 12, 1 + months % 12, 14, 6, tzinfo=timezone(timedelta(hours=8)))


def draw_epochs(request: SimulatedCampaignRequest) -> tuple[SimulatedEpoch, ...]:
    """What is known of every epoch before its scans."""
    epochs = []
    for index in range(request.epochs):
        shape = request.movement.shape_at(request.shape, index)
        truth = axis_truth(shape, *request.shaft_z_m)
        noise = REFERENCE_SIGMA * np.random.default_rng([request.seed, 1, index]).normal(size=2)
        reference = Horizontal(float(truth.lean.east + noise[0]), float(truth.lean.north + noise[1]))
        epochs.append(SimulatedEpoch(index, shape, truth, reference))
    return tuple(epochs)


def scan_epochs(
    request: SimulatedCampaignRequest,
) -> Iterator[tuple[SimulatedEpoch, Iterator[SimulatedStation]]]:
    """Scan epoch after epoch on one site; an epoch stays the same however many others are asked for."""
    site_rng = np.random.default_rng([request.seed, 0])
    places_m = draw_station_places(request.stations, site_rng, request.layout)
    body = Body(request.fittings, request.wall, request.attachments)
    site = build_site(places_m, site_rng, request.surroundings)
    for epoch in draw_epochs(request):
        rng = np.random.default_rng([request.seed, 2, epoch.index])
        setups = set_up_epoch(site, places_m, request.scanner, rng, request.layout)
        scene = epoch_scene(site, epoch.shape, body)
        yield epoch, simulate_epoch(scene, epoch.shape, setups, request.scanner, request.points, rng)
