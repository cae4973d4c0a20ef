"""Uncertainty: what points, levelling and registration of the stations do to the lean vector."""

from tasks.uncertainty.jackknife import (
    Source,
    Stated,
    hotelling_factor,
    jackknife_covariance,
    state_covariance,
)
from tasks.uncertainty.joint_slices import JointSlices, PlacedStations, SlicedShaft, joint_parts, joint_slices
from tasks.uncertainty.poses import combine, propagate_directional_poses, propagate_poses
from tasks.uncertainty.slice_bootstrap import bootstrap_slices
from tasks.uncertainty.slice_runs import form_of_slices
from tasks.uncertainty.station_sums import (
    Ring,
    Skin,
    base_leverage,
    changes_without_each,
    leverage,
    moved_by_poses,
    pose_jacobian,
    sum_by_station,
    sum_ring_by_station,
)

__all__ = [
    "JointSlices",
    "PlacedStations",
    "Ring",
    "Skin",
    "SlicedShaft",
    "Source",
    "Stated",
    "base_leverage",
    "bootstrap_slices",
    "changes_without_each",
    "combine",
    "form_of_slices",
    "hotelling_factor",
    "jackknife_covariance",
    "joint_parts",
    "joint_slices",
    "leverage",
    "moved_by_poses",
    "pose_jacobian",
    "propagate_directional_poses",
    "propagate_poses",
    "state_covariance",
    "sum_by_station",
    "sum_ring_by_station",
]
