"""Surroundings that do not move, taken from the reference epoch: what later epochs may share their frame by."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.geometry.failure import FitFailure
from tasks.registration.even_sample import Cloud
from tasks.registration.planar import COARSE, FINE, PlanarCloud, ScanPlanes, scan_planes
from tasks.registration.station import Registration, StationPose

MIN_PLANES: Final = 300
"""Fewer planar points in all boxes together hold no frame."""


@dataclass(frozen=True, slots=True)
class StableBox:
    """A part of the surroundings that does not move: two corners in the site frame, metres."""

    name: str
    low_m: tuple[float, float, float]
    high_m: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class StableSurroundings:
    """Planar points of the reference epoch in the boxes.

    ``points_m`` (n, 3) and ``normals`` (n, 3) in the site frame; ``tilts`` (n, 2, 3) as in ``PlanarCloud``; ``is_ground``
    (n,) is 1 for planes of the coarse scale, else 0.
    ``covariance`` (6, 6) is that of the reference epoch's frame: a rotation about the site's origin, then a shift.
    """

    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    tilts: NDArray[np.float64]
    is_ground: NDArray[np.float64]
    covariance: NDArray[np.float64]


def stable_surroundings(
    scans_m: Sequence[Cloud], registration: Registration, boxes: Sequence[StableBox]
) -> StableSurroundings | FitFailure:
    """Take the planes inside the boxes out of the scans (n_i, 3), scanner frames, of a registered epoch."""
    parts = [
        _inside(layer, pose, boxes, is_ground)
        for planes, pose in zip(scan_planes(scans_m), registration.poses, strict=True)
        for layer, is_ground in zip(planes.layers, (0.0, 1.0), strict=True)
    ]
    n_planes = sum(len(part.points_m) for part in parts)
    if n_planes < MIN_PLANES:
        names = ", ".join(box.name for box in boxes)
        return FitFailure(
            f"the stable surroundings ({names}) hold {n_planes} planes in the reference epoch, needed {MIN_PLANES}; "
            "make the boxes larger or choose others"
        )
    return StableSurroundings(
        np.concatenate([part.points_m for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.tilts for part in parts]),
        np.concatenate([part.is_ground for part in parts]),
        frame_covariance(registration),
    )


def stable_planes(surroundings: StableSurroundings) -> ScanPlanes:
    """Give stable surroundings their search trees."""
    return ScanPlanes(
        _layer(surroundings, surroundings.is_ground == 0.0, FINE.reach_m),
        _layer(surroundings, surroundings.is_ground == 1.0, COARSE.reach_m),
    )


def frame_covariance(registration: Registration) -> NDArray[np.float64]:
    """Covariance (6, 6) of an epoch's frame as a whole: rotation about the site's origin, then shift."""
    by_motion = np.concatenate([pose_by_motion(pose) for pose in registration.poses])
    information = by_motion.T @ np.linalg.solve(registration.covariance, by_motion)
    return np.asarray(np.linalg.inv(information))


def pose_by_motion(pose: StationPose) -> NDArray[np.float64]:
    """Derivative (6, 6) of a pose by a rotation of the frame about the site's origin and a shift."""
    derivative = np.eye(SIX)
    x, y, z = pose.position_m
    # rotation w moves the scanner by w x p
    derivative[3:, :3] = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return derivative


@dataclass(frozen=True, slots=True)
class _Part:
    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    tilts: NDArray[np.float64]
    is_ground: NDArray[np.float64]


def _inside(cloud: PlanarCloud, pose: StationPose, boxes: Sequence[StableBox], is_ground: float) -> _Part:
    placed = pose.to_site(cloud.points_m)
    keep = np.zeros(len(placed), bool)
    for box in boxes:
        low, high = np.asarray(box.low_m), np.asarray(box.high_m)
        keep |= ((placed >= low) & (placed <= high)).all(axis=1)
    turned = pose.rotation.T
    return _Part(
        placed[keep], cloud.normals[keep] @ turned, cloud.tilts[keep] @ turned, np.full(keep.sum(), is_ground)
    )


def _layer(surroundings: StableSurroundings, keep: NDArray[np.bool_], reach_m: float) -> PlanarCloud:
    from scipy.spatial import KDTree  # noqa: PLC0415 (slow to import)

    points = surroundings.points_m[keep]
    return PlanarCloud(points, surroundings.normals[keep], surroundings.tilts[keep], KDTree(points), reach_m)
