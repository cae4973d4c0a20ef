"""Inspect the scans of a campaign by their headers: everything that is wrong, before any point is read."""

import filecmp
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from storage.drawing.projected_system import projected_system
from storage.errors import InputError
from tasks.ingest import Bounds, ScanHeader, ScanPart, describe_scan
from tasks.plan import REGISTERED, PlannedScan, plan_prior, plan_scans
from tasks.settings import Campaign, Epoch


@dataclass(frozen=True, slots=True)
class InspectedScan:
    """What the header of a scan says; ``n_points`` is None where only reading tells.

    ``horizontal`` is the coordinate system that the file states, "EPSG:n" or its name in quotes.
    """

    epoch: str
    station: str
    path: Path
    part: str | int | None
    format: str
    n_points: int | None
    size_bytes: int
    horizontal: str | None


@dataclass(frozen=True, slots=True)
class Inspection:
    """The scans whose headers are sound, and a line ``place: what; hint`` for everything that is wrong."""

    scans: tuple[InspectedScan, ...]
    problems: tuple[str, ...]


def inspect_campaign(campaign: Campaign) -> Inspection:
    """Read the header of every scan of a campaign; no points."""
    scans: list[InspectedScan] = []
    problems: list[str] = []
    for epoch in campaign.epochs:
        for planned in plan_scans(campaign, epoch):
            try:
                header = describe_scan(planned.path, planned.request)
            except InputError as error:
                problems.append(f"{place_of(epoch.id, planned.station)}: {error}")
                continue
            scans.append(_inspected(epoch, planned, header))
            problems.extend(_header_problems(campaign, epoch, planned, header))
    return Inspection(tuple(scans), (*_frame_problems(campaign), *problems, *_copies(scans)))


def _frame_problems(campaign: Campaign) -> Iterator[str]:
    if campaign.frame.horizontal == "local":
        return
    try:
        projected_system(int(campaign.frame.horizontal.removeprefix("EPSG:")))
    except InputError as error:
        yield f"frame.horizontal: {error}"


def place_of(epoch: str, station: str) -> str:
    """Name the key of the campaign file that names a scan."""
    if station == REGISTERED:
        return f"epochs[{epoch}].registered"
    return f"epochs[{epoch}].stations[{station}].scan"


def _inspected(epoch: Epoch, planned: PlannedScan, header: ScanHeader) -> InspectedScan:
    return InspectedScan(
        epoch=epoch.id,
        station=planned.station,
        path=planned.path,
        part=planned.request.part,
        format=header.format,
        n_points=header.n_points,
        size_bytes=header.size_bytes,
        horizontal=header.horizontal,
    )


def _header_problems(
    campaign: Campaign, epoch: Epoch, planned: PlannedScan, header: ScanHeader
) -> Iterator[str]:
    place = place_of(epoch.id, planned.station)
    if header.n_points == 0:
        yield f"{place}: {planned.path} holds no points; export the scan again"
    elif planned.is_registered and header.bounds is not None:
        yield from (f"{place}: {what}" for what in _misses(campaign, header.bounds))
    elif planned.has_pose_in_file and any(part.pose is None for part in _asked_for(planned, header)):
        yield (
            f'{place}: {planned.path} states no pose of this scan, which pose = "file" needs; '
            "write position_m and heading_deg instead"
        )


def _asked_for(planned: PlannedScan, header: ScanHeader) -> Iterator[ScanPart]:
    """The scan of a file with several that a station names; none where the header does not tell scans apart."""
    for number, part in enumerate(header.parts, start=1):
        if planned.request.part in (None, number, part.name):
            yield part


def _misses(campaign: Campaign, bounds: Bounds) -> Iterator[str]:
    """Say whether a registered cloud cannot hold the shaft: then origin, axes or unit are wrong."""
    frame, prior = campaign.frame, plan_prior(campaign)
    order = [1, 0, 2] if frame.swaps_axes else [0, 1, 2]
    low, high = ((corner - np.asarray(frame.origin_m))[order] for corner in (bounds.low, bounds.high))
    radius_m = max(prior.radius_m)
    wanted_low = np.array([*(value - radius_m for value in prior.base_xy_m), prior.shaft_z_m[0]])
    wanted_high = np.array([*(value + radius_m for value in prior.base_xy_m), prior.shaft_z_m[1]])
    for axis, from_m, to_m, first_m, last_m in zip(
        ("east", "north", "up"), low, high, wanted_low, wanted_high, strict=True
    ):
        if to_m < first_m or from_m > last_m:
            yield (
                f"{axis} runs from {from_m:.1f} to {to_m:.1f} m after frame.origin_m, the shaft from {first_m:.1f} to "
                f"{last_m:.1f} m; check frame.origin_m, frame.axes, structure.base_xy_m and the unit (metres, not feet)"
            )


def _copies(scans: Sequence[InspectedScan]) -> Iterator[str]:
    """List scans that are byte for byte the same: two set-ups never see the same noise.

    Two stations may name different scans of one file, or of two files with the same scans.
    """
    for first, second in combinations(scans, 2):
        if first.part != second.part:
            continue
        if first.size_bytes == second.size_bytes and filecmp.cmp(first.path, second.path, shallow=False):
            yield (
                f"{place_of(second.epoch, second.station)}: {second.path} is a copy of "
                f"{place_of(first.epoch, first.station)}; name the scan that belongs here"
            )
