"""What is written about a simulated campaign: its truth, and its campaign file in the form of the contract."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np

from tasks.conventions import azimuth_deg
from tasks.simulation.attachments import Attachments
from tasks.simulation.campaign import REFERENCE_SIGMA, SimulatedCampaignRequest, SimulatedEpoch
from tasks.simulation.epoch import SimulatedStation
from tasks.simulation.mesh import Surface
from tasks.simulation.movement import Movement
from tasks.simulation.scanner import Scanner
from tasks.simulation.shape import ShaftShape
from tasks.simulation.structure import Fittings
from tasks.simulation.wall import Wall

_CONVENTIONS: Final = (
    "lean_fit: east, north, of the least-squares line to the true axis, uniform in height; headings clockwise from "
    "north to the scanner's +y; points_site = level @ heading @ points_scanner + position"
)


@dataclass(frozen=True, slots=True)
class StationTruth:
    """A station as ``truth.json`` has it; headings as everywhere here, clockwise from north to scanner's +y."""

    id: str
    file: str
    points: int
    gnss: list[float]
    heading_deg: float
    true_position: list[float]
    true_heading_deg: float
    true_level_east_deg: float
    true_level_north_deg: float
    points_by_surface: dict[str, int]


def station_truth(station: SimulatedStation) -> StationTruth:
    """Write down a station as it truly stood and as the crew stated it; what is stated is rounded as in the file."""
    setup, scan = station.setup, station.scan
    counts = Counter(scan.surface.tolist())
    return StationTruth(
        id=setup.station,
        file=f"{setup.station}.laz",
        points=len(scan.points_m),
        gnss=np.round(setup.stated_position_m, 4).tolist(),
        heading_deg=round(float(np.degrees(setup.stated_heading_rad)), 6),
        true_position=setup.position_m.tolist(),
        true_heading_deg=float(np.degrees(setup.heading_rad)),
        true_level_east_deg=float(np.degrees(setup.level_east_rad)),
        true_level_north_deg=float(np.degrees(setup.level_north_rad)),
        points_by_surface={surface.name.lower(): counts.get(int(surface), 0) for surface in Surface},
    )


@dataclass(frozen=True, slots=True)
class EpochTruth:
    """An epoch as ``truth.json`` has it; a superset of what the shared scoring tool reads."""

    epoch: str
    lean_fit: list[float]
    tilt_deg: float
    azimuth_deg: float
    base_m: list[float]
    bending_m: float
    fitted_over_z_m: list[float]
    conventions: str
    seed: int
    shape: ShaftShape
    movement: Movement
    scanner: Scanner
    fittings: Fittings
    stations: list[StationTruth]
    points: int
    wall: Wall | None = None
    attachments: Attachments | None = None

    def as_json(self) -> dict[str, object]:
        """Everything as plain values; what a plain chimney has not is left out."""
        return {name: value for name, value in asdict(self).items() if value is not None}


def epoch_truth(
    request: SimulatedCampaignRequest, epoch: SimulatedEpoch, stations: Sequence[StationTruth]
) -> EpochTruth:
    """Write down the truth of an epoch and what was done."""
    line = epoch.truth
    return EpochTruth(
        epoch=epoch.name,
        lean_fit=[line.lean.east, line.lean.north],
        tilt_deg=float(np.degrees(line.tilt_rad)),
        azimuth_deg=azimuth_deg(line.lean.east, line.lean.north),
        base_m=[line.base_m.east, line.base_m.north],
        bending_m=line.bending_m,
        fitted_over_z_m=list(request.shaft_z_m),
        conventions=_CONVENTIONS,
        seed=request.seed,
        shape=epoch.shape,
        movement=request.movement,
        scanner=request.scanner,
        fittings=request.fittings,
        stations=list(stations),
        points=sum(station.points for station in stations),
        wall=request.wall,
        attachments=request.attachments,
    )


def campaign_head(request: SimulatedCampaignRequest) -> str:
    """Everything of the campaign file but its epochs."""
    shape, scanner = request.shape, request.scanner
    low_m, high_m = request.shaft_z_m
    slices = int(high_m - low_m - 0.01 + 1e-6) + 1
    return f"""\
# a simulated campaign: the truth of each epoch stands in its truth.json
schema_version = 1

[structure]
id = "demo-{request.kind}"
name = "Simulated {request.kind}"
kind = "{request.kind}"
height_m = {high_m - 0.01:.1f}
shaft_z_m = [{low_m:.1f}, {high_m:.2f}]  # {slices} slices of 1 cm, one every metre
base_xy_m = [{round(shape.base_m.east, 1) + 0.0}, {round(shape.base_m.north, 1) + 0.0}]
radius_m = [{request.radius_m[0]:.2g}, {request.radius_m[1]:.2g}]

[frame]
axes = "ENU"
horizontal = "local"

[instrument]  # what was simulated
range_sigma_m = {scanner.range_sigma_m}  # at 100 m, in proportion to the range
angle_sigma_deg = {scanner.angle_sigma_deg}
level_sigma_deg = {scanner.level_sigma_deg}
position_sigma_m = [{scanner.position_sigma_m}, {scanner.height_sigma_m}]
heading_sigma_deg = {scanner.heading_sigma_deg}

{_limits(request.limits)}[report]
primary = ["S", "surface"]
control = ["F", "paper"]
"""


def _limits(names: Sequence[str]) -> str:
    """The table of limits, nothing where there is none; the first one counts, the others are judged beside it."""
    if not names:
        return ""
    also = f"also = [{', '.join(f'{chr(34)}{name}{chr(34)}' for name in names[1:])}]\n" if names[1:] else ""
    return f'[limits]\ntable = "{names[0]}"\n{also}\n'


def campaign_epoch(epoch: SimulatedEpoch, stations: Sequence[StationTruth]) -> str:
    """The table of one epoch of the campaign file."""
    lines = ["[[epochs]]", f'id = "{epoch.name}"', f"time = {epoch.time.isoformat()}"]
    if epoch.index == 0:
        lines.append("reference = true")
    for station in stations:
        east_m, north_m, up_m = station.gnss
        lines += [
            "[[epochs.stations]]",
            f'id = "{station.id}"',
            f'scan = "{epoch.name}/{station.file}"',
            f"position_m = [{east_m:.4f}, {north_m:.4f}, {up_m:.4f}]",
            f"heading_deg = {station.heading_deg:.6f}",
        ]
    lines += [
        "[[epochs.references]]",
        'source = "total station"',
        f"lean_east = {epoch.reference.east:.8f}",
        f"lean_north = {epoch.reference.north:.8f}",
        f"sigma = {REFERENCE_SIGMA:.5f}",
    ]
    return "\n".join(lines) + "\n"
