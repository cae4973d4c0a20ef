"""Poses that no adjustment of ours made, in the form of one."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from benchmarks.registration.known import KnownEpoch
from storage.errors import ShapeError
from tasks.conventions import rotation_site_scanner
from tasks.registration import InstrumentSigmas, Registration, StationPose, registered_cloud


def unadjusted(poses: Sequence[StationPose], sigmas: InstrumentSigmas) -> Registration:
    """Poses as they are, with the sigmas of the instruments: the lean itself does not depend on these."""
    each = [registered_cloud(pose.station, sigmas) for pose in poses]
    return replace(
        each[0],
        poses=tuple(poses),
        covariance=block_diag(*(one.covariance for one in each)),
        diagnoses=tuple(diagnosis for one in each for diagnosis in one.diagnoses),
    )


def stated_poses(epoch: KnownEpoch) -> list[StationPose]:
    """The poses that the crew states, plumb."""
    poses = []
    for scan in epoch.scans:
        if scan.position_m is None or scan.heading_rad is None:
            raise ShapeError(f"a coarse start needs position and heading; {scan.station} lacks one")
        poses.append(StationPose(scan.station, rotation_site_scanner(scan.heading_rad), scan.position_m))
    return poses


def matrix_of(pose: StationPose, centre_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Homogeneous T_centred_scanner (4, 4): the site frame shifted by ``centre_m`` (3,)."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.position_m - centre_m
    return matrix


def pose_of(station: str, matrix: NDArray[np.float64], centre_m: NDArray[np.float64]) -> StationPose:
    """The pose (4, 4) back in the site frame."""
    return StationPose(station, matrix[:3, :3], matrix[:3, 3] + centre_m)
