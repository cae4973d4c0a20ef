"""Search for where a station stood whose pose is not stated or cannot be right."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from tasks.geometry.failure import FitFailure
from tasks.registration.placement import Placement, settle_alone, without_structure
from tasks.registration.planar import ScanPlanes
from tasks.registration.sighting import Sighting
from tasks.registration.sights import Sights
from tasks.registration.station import StationPose, StationScan
from tasks.registration.surroundings import PoseOfHeading, draw_plan, ground_offset_m, likely_headings

LEAST_PLANES: Final = 150
"""Fewer planes in common with the other stations beside the structure do not say where a station stood."""

CLEARLY: Final = 1.5
"""The best place must have that many times the planes in common of the best other place."""

SAME_PLACE_M: Final = 1.0
STRUCTURE_M: Final = 1.0
"""So near to where the others see the structure must a placed station see it."""


@dataclass(frozen=True, slots=True)
class Neighbours:
    """Stations that are placed well."""

    planes: tuple[ScanPlanes, ...]
    poses: tuple[StationPose, ...]


def place_lost(
    scan: StationScan, planes: ScanPlanes, neighbours: Neighbours, sights: Sights | None, i: int
) -> StationPose | FitFailure:
    """Find the pose of a station by the structure that it sees and by what stands around; or say why it cannot be found."""
    sighting = None if sights is None else sights.sightings[i]
    around = _around(scan, sights, sighting)
    if around is None or not neighbours.poses:
        return FitFailure("no well-placed station is there to place it by")
    own = without_structure(planes, None if sighting is None else sighting.centre_m, _radius_m(sights))
    others = [
        _beside(one, pose, sights) for one, pose in zip(neighbours.planes, neighbours.poses, strict=True)
    ]
    placements = list(_placements(own, around, others, neighbours.poses))
    if sights is not None and sighting is not None:
        placements = [one for one in placements if _off_structure_m(one, sighting, sights) < STRUCTURE_M]
    return _clear_one(placements)


def _around(scan: StationScan, sights: Sights | None, sighting: Sighting | None) -> PoseOfHeading | None:
    """Where to search: around the structure where it is seen, else at the stated place."""
    if sights is not None and sighting is not None:
        height = 0.0 if scan.position_m is None else float(scan.position_m[2])
        return PoseOfHeading(scan.station, np.r_[sights.shaft_m, height], sighting.centre_m)
    return (
        None if scan.position_m is None else PoseOfHeading(scan.station, np.asarray(scan.position_m, float))
    )


def _radius_m(sights: Sights | None) -> float:
    return 0.0 if sights is None else max(sights.hint.radius_m)


def _beside(planes: ScanPlanes, pose: StationPose, sights: Sights | None) -> ScanPlanes:
    if sights is None:
        return planes
    seen_at = (pose.rotation.T @ np.r_[sights.shaft_m - pose.position_m[:2], 0.0])[:2]
    return without_structure(planes, seen_at, _radius_m(sights))


def _placements(
    own: ScanPlanes, around: PoseOfHeading, others: Sequence[ScanPlanes], poses: Sequence[StationPose]
) -> Iterator[Placement]:
    plan = draw_plan(others, poses)
    for heading in likely_headings(plan, own, around):
        start = around.pose(heading)
        rise = ground_offset_m(plan, own, start)
        if rise is not None:
            raised = StationPose(start.station, start.rotation, start.position_m + np.array([0.0, 0.0, rise]))
            yield settle_alone(own, raised, others, poses)


def _off_structure_m(placement: Placement, sighting: Sighting, sights: Sights) -> float:
    seen = placement.pose.to_site(np.r_[sighting.centre_m, 0.0][None])[0, :2]
    return float(np.hypot(*(seen - sights.shaft_m)))


def _clear_one(placements: list[Placement]) -> StationPose | FitFailure:
    """Choose the placement that has clearly more in common with the other stations than any other."""
    ranked = sorted(placements, key=lambda one: -(one.n_walls + one.n_ground))
    if not ranked or ranked[0].n_walls + ranked[0].n_ground < LEAST_PLANES:
        return FitFailure("what it sees beside the structure fits that of the others nowhere")
    best = ranked[0]
    for other in ranked[1:]:
        is_elsewhere = np.linalg.norm(other.pose.position_m - best.pose.position_m) > SAME_PLACE_M
        if is_elsewhere and CLEARLY * (other.n_walls + other.n_ground) > best.n_walls + best.n_ground:
            return FitFailure(
                "what it sees beside the structure fits that of the others in more than one place"
            )
    return best.pose
