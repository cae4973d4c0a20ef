"""The pose that is stated for a scan: by the campaign, or by the scan file."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from tasks.plan import PlannedScan
from tasks.produced import Json
from tasks.settings import Campaign
from tasks.settings.cross_checks import FARTHEST_M


@dataclass(frozen=True, slots=True)
class StatedPose:
    """Position of the scanner in the site frame, and its heading; None where nothing is stated."""

    position_m: tuple[float, float, float] | None
    heading_rad: float | None


def stated_pose(campaign: Campaign, planned: PlannedScan, facts: Mapping[str, Json]) -> StatedPose:
    """What is stated of the pose of a scan; ``facts`` are those of its ingest, where a pose in the file stands."""
    if not planned.has_pose_in_file:
        return StatedPose(planned.position_m, planned.heading_rad)
    east, north, up = cast("list[float]", facts["position_m"])
    position_m = campaign.frame.site_position_m((east, north, up))
    return StatedPose(position_m, float(np.radians(cast("float", facts["heading_deg"]))))


def refuse_far_pose(campaign: Campaign, planned: PlannedScan, facts: Mapping[str, Json]) -> str | None:
    """Why the pose that a file states cannot be meant in the frame; of one that the campaign states, it has said so."""
    if not planned.has_pose_in_file:
        return None
    pose = stated_pose(campaign, planned, facts)
    away_m = max(abs(value) for value in pose.position_m or ())
    if away_m <= FARTHEST_M:
        return None
    return (
        f"needs a pose within {FARTHEST_M:.0f} m of the origin, came one {away_m:.0f} m away; write frame.origin_m near "
        "the structure, or position_m and heading_deg"
    )
