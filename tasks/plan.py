"""From the campaign file to what each stage is asked: the only place where settings meet stages."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from storage.errors import InputError
from tasks.evaluation import Occasion, ReferenceLean, Standard
from tasks.ingest import ScanRequest
from tasks.methods import Method, methods_of
from tasks.preprocessing import ShaftOptions, StructurePrior
from tasks.registration import InstrumentSigmas, ShaftHint, StableBox, Ties
from tasks.settings import Campaign, Epoch, Station
from tasks.slicing import SCHEMES, SlicingScheme, user_scheme

REGISTERED: Final = "registered"
"""Stands as station id for a cloud that comes registered."""


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
    yield from SCHEMES.items()
    for name, own in campaign.schemes.items():
        yield name, user_scheme(name, own.interval_m, own.heights_m, own.thickness_m)


def plan_sigmas(campaign: Campaign) -> InstrumentSigmas:
    """Priors of the adjustment, from what the maker states."""
    instrument = campaign.instrument
    return InstrumentSigmas(
        position_m=instrument.position_sigma_m,
        heading_rad=float(np.radians(instrument.heading_sigma_deg)),
        level_rad=float(np.radians(instrument.level_sigma_deg)),
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
    first, second = campaign.structure.base_xy_m
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
        limit_table=campaign.limits.table,
        limit_points_m=campaign.limits.verticality_m,
        control=(control,) if isinstance(control, str) else tuple(control),
        references=tuple(ReferenceLean(r.source, r.lean_east, r.lean_north) for r in epoch.references),
    )


def plan_occasion(campaign: Campaign, epoch: Epoch) -> Occasion:
    """Which structure and epoch."""
    return Occasion(campaign.structure.id, epoch.id, epoch.time.isoformat())
