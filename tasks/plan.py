"""From the campaign file to what each stage is asked: the only place where settings meet stages."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from storage.errors import InputError
from tasks.evaluation import Occasion, ReferenceLean, Standard
from tasks.ingest import ScanRequest
from tasks.limit_choice import further_limits, primary_limit
from tasks.map_shapes import DesignedShape
from tasks.methods import Method, methods_of, needs_sights, suited_to
from tasks.preprocessing import ShaftOptions, StructurePrior
from tasks.registration import InstrumentSigmas, ShaftHint, StableBox, Ties
from tasks.settings import Campaign, Epoch, Station
from tasks.sight_noise import ScannerNoise
from tasks.slicing import SCHEMES, SlicingScheme
from tasks.surface_map import MapQuestion
from tasks.whole_surface import SurfaceQuestion

REGISTERED: Final = "registered"
"""Stands as station id for a cloud that comes registered."""

WHOLE_SURFACE: Final = ("S", "surface")
"""Scheme and method of the map of the surface where the primary ones have slices."""


@dataclass(frozen=True, slots=True)
class PlannedScan:
    """A scan file, how to read it, and the pose that the campaign states for it.

    Position and heading are None where the campaign states none: of a cloud that is registered, and of a station whose
    pose is in its file or is to be found.
    """

    station: str
    path: Path
    request: ScanRequest
    position_m: tuple[float, float, float] | None
    heading_rad: float | None

    @property
    def is_registered(self) -> bool:
        """Whether it is a cloud in the frame, and no scan of a station."""
        return self.request.frame == "file"

    @property
    def has_pose_in_file(self) -> bool:
        """Whether its file states position, heading and levelling."""
        return self.request.levelling == "file"


@dataclass(frozen=True, slots=True)
class PlannedAxis:
    """A scheme and a method to measure it with."""

    scheme: SlicingScheme
    method: Method

    @property
    def label(self) -> str:
        """Scheme/method, as in the ledger."""
        return f"{self.scheme.name}/{self.method.name}"


def plan_scans(campaign: Campaign, epoch: Epoch) -> list[PlannedScan]:
    """List the scans of an epoch in the order of the file.

    Raises
    ------
    InputError
        If a path leaves the campaign's folder.
    """
    if epoch.registered is not None:
        return [_plan_registered(campaign, epoch.registered)]
    return [_plan_station(campaign, station) for station in epoch.stations]


def _plan_registered(campaign: Campaign, cloud: str) -> PlannedScan:
    frame = campaign.frame
    request = ScanRequest(
        origin_m=frame.origin_m,
        swap_axes=frame.swaps_axes,
        frame="file",
        horizontal=frame.horizontal,
    )
    return PlannedScan(REGISTERED, campaign.scan_path(cloud), request, None, None)


def _plan_station(campaign: Campaign, station: Station) -> PlannedScan:
    position_m, heading_deg = station.position_m, station.heading_deg
    return PlannedScan(
        station=station.id,
        path=campaign.scan_path(station.scan),
        request=ScanRequest(
            coordinates=station.coordinates,
            part=station.part,
            levelling="file" if station.pose == "file" else "scanner",
        ),
        position_m=None if position_m is None else campaign.frame.site_position_m(position_m),
        heading_rad=None if heading_deg is None else float(np.radians(heading_deg)),
    )


def plan_axes(campaign: Campaign, names: Sequence[str] = ()) -> list[PlannedAxis]:
    """List schemes and methods to measure: all, or those of the schemes named.

    Raises
    ------
    InputError
        If a name is not that of a scheme; the message lists the known ones.
    """
    schemes = dict(_schemes(campaign))
    unknown = [name for name in names if name not in schemes]
    if unknown:
        raise InputError(f"unknown slicing scheme {unknown[0]!r}; known: {', '.join(sorted(schemes))}")
    chosen = [scheme for name, scheme in schemes.items() if not names or name in names]
    return [PlannedAxis(scheme, method) for scheme in chosen for method in methods_of(scheme)]


def _schemes(campaign: Campaign) -> Iterator[tuple[str, SlicingScheme]]:
    kind = campaign.structure.kind
    for name, scheme in SCHEMES.items():
        yield name, suited_to(scheme, kind)
    for name, own in campaign.schemes.items():
        yield name, suited_to(own.as_scheme(name), kind)


def plan_sigmas(campaign: Campaign) -> InstrumentSigmas:
    """Priors of the adjustment, from what the maker states."""
    instrument = campaign.instrument
    return InstrumentSigmas(
        position_m=instrument.position_sigma_m,
        heading_rad=float(np.radians(instrument.heading_sigma_deg)),
        level_rad=float(np.radians(instrument.level_sigma_deg)),
    )


def plan_sight_noise(campaign: Campaign, epoch: Epoch, axis: PlannedAxis) -> ScannerNoise | None:
    """Noise of the scanner where slicing needs the sigma of every point; None where not, or nobody knows who saw it."""
    if epoch.registered is not None or not needs_sights(axis.scheme, axis.method):
        return None
    instrument = campaign.instrument
    return ScannerNoise(instrument.range_sigma_m, float(np.radians(instrument.angle_sigma_deg)))


def plan_surface(campaign: Campaign, axis: PlannedAxis) -> SurfaceQuestion:
    """How the whole surface of the shaft is to be fitted.

    Raises
    ------
    InputError
        If the scheme has slices.
    """
    if axis.scheme.surface is None:
        raise InputError(f"scheme {axis.scheme.name} has slices, and no surface model")
    structure = campaign.structure
    return SurfaceQuestion(axis.scheme.surface, structure.shaft_z_m, structure.sections)


def plan_mapped_axis(campaign: Campaign) -> tuple[str, str]:
    """Scheme and method whose axis the map of the surface rests on: the primary one if it takes the whole surface."""
    name, method = campaign.report.primary
    scheme = dict(_schemes(campaign))[name]
    return (name, method) if scheme.surface is not None else WHOLE_SURFACE


def plan_surface_map(campaign: Campaign) -> MapQuestion:
    """What the map of the surface is measured from, in the site frame."""
    structure = campaign.structure
    return MapQuestion(structure.shaft_z_m, structure.sections, _design(campaign))


def _design(campaign: Campaign) -> DesignedShape | None:
    structure = campaign.structure
    if structure.design_radius_m is None:
        return None
    base_xy_m = structure.design_base_xy_m
    return DesignedShape(
        z_m=tuple(z_m for z_m, _ in structure.design_radius_m),
        radius_m=tuple(radius_m for _, radius_m in structure.design_radius_m),
        lean=structure.design_lean,
        base_xy_m=None if base_xy_m is None else _east_north(campaign, base_xy_m),
    )


def plan_prior(campaign: Campaign) -> StructurePrior:
    """What is roughly known of the structure, in the site frame."""
    structure = campaign.structure
    return StructurePrior(
        kind=structure.kind,
        shaft_z_m=structure.shaft_z_m,
        base_xy_m=_base_xy_m(campaign),
        radius_m=structure.radius_m,
    )


def plan_shaft_hint(campaign: Campaign) -> ShaftHint:
    """What registration may look for where a pose is not known, in the site frame."""
    structure = campaign.structure
    is_tied = campaign.registration.common_shaft and structure.kind != "square-tower"
    ties: Ties = "common shaft" if is_tied else "none"
    return ShaftHint(_base_xy_m(campaign), structure.shaft_z_m, structure.radius_m, ties)


def _base_xy_m(campaign: Campaign) -> tuple[float, float]:
    return _east_north(campaign, campaign.structure.base_xy_m)


def _east_north(campaign: Campaign, xy_m: tuple[float, float]) -> tuple[float, float]:
    first, second = xy_m
    return (second, first) if campaign.frame.swaps_axes else (first, second)


def plan_stable(campaign: Campaign) -> tuple[StableBox, ...]:
    """Boxes of surroundings that do not move, in the site frame."""
    place = campaign.frame.site_position_m
    return tuple(
        StableBox(region.name, place(region.low_m), place(region.high_m))
        for region in campaign.registration.stable
    )


def plan_options(campaign: Campaign) -> ShaftOptions:
    """Options of the isolation of the shaft."""
    return ShaftOptions(**campaign.preprocessing.model_dump())


def plan_standard(campaign: Campaign, epoch: Epoch) -> Standard:
    """What the results of an epoch are measured against."""
    control = campaign.report.control
    return Standard(
        height_m=campaign.structure.height_m,
        limit=primary_limit(campaign, epoch.time),
        control=(control,) if isinstance(control, str) else tuple(control),
        references=plan_references(epoch),
        also=further_limits(campaign, epoch.time),
    )


def plan_references(epoch: Epoch) -> tuple[ReferenceLean, ...]:
    """Leans of an epoch that were measured by other means, in the order of the file."""
    return tuple(ReferenceLean(r.source, r.lean_east, r.lean_north, r.sigma) for r in epoch.references)


def plan_occasion(campaign: Campaign, epoch: Epoch) -> Occasion:
    """Which structure and epoch."""
    return Occasion(campaign.structure.id, epoch.id, epoch.time.isoformat())
