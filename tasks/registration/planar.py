"""The planar points of a scan: where a neighbouring scan can be compared along a normal."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from tasks.geometry.side_by_side import side_by_side
from tasks.geometry.voxels import first_in_voxel


@dataclass(frozen=True, slots=True)
class PlaneScale:
    """At what scale planes are looked for, metres.

    ``voxel_m`` is the spacing of the points that make a plane, ``spacing_m`` that of the planes; ``radius_m`` is the
    neighbourhood of a normal; a plane holds at least ``reach_m`` from the point that stands for it.
    """

    voxel_m: float
    spacing_m: float
    radius_m: float
    reach_m: float


FINE: Final = PlaneScale(voxel_m=0.3, spacing_m=0.45, radius_m=0.7, reach_m=0.5)
"""Shaft and facades: finer brings correlated points, not information; wide against 2 cm of noise, narrow against a
shaft of 2 m radius."""

COARSE: Final = PlaneScale(voxel_m=1.2, spacing_m=2.0, radius_m=4.0, reach_m=3.0)
"""The ground: from a tripod it is seen at a grazing angle, at 100 m its scan lines lie metres apart."""

LYING: Final = 0.7
"""Smallest share of up in the normal of ground."""

NEIGHBOURS: Final = 16
MIN_NEIGHBOURS: Final = 8
FLATNESS: Final = 0.05
"""Largest share of the smallest in the middle eigenvalue of a planar neighbourhood."""

PLANE_PARAMETERS: Final = 3


@dataclass(frozen=True, slots=True)
class PlanarCloud:
    """Planar points (n, 3) and unit normals (n, 3) in one frame, with their search tree.

    ``tilts`` (n, 2, 3) are two tangents of every plane, each as long as the standard deviation (rad) by which the
    normal may lean that way: what the noise of the points leaves open. A plane holds ``reach_m`` around its point.
    """

    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    tilts: NDArray[np.float64]
    tree: KDTree
    reach_m: float


@dataclass(frozen=True, slots=True)
class ScanPlanes:
    """The planes of a scan: of shaft and facades, and of the ground at its own, coarser scale."""

    fine: PlanarCloud
    coarse: PlanarCloud

    @property
    def layers(self) -> tuple[PlanarCloud, PlanarCloud]:
        """Both, the fine one first."""
        return self.fine, self.coarse


def scan_planes(scans_m: Sequence[NDArray[np.float64]]) -> list[ScanPlanes]:
    """Planes of several scans (n_i, 3), each in its own scanner frame."""
    return side_by_side(planes_of_scan, scans_m)


def planes_of_scan(points_m: NDArray[np.float64]) -> ScanPlanes:
    """Planes of a scan (n, 3): fine ones, and where there is none, those of the ground."""
    thin = points_m[first_in_voxel(points_m, FINE.voxel_m)]
    fine, rest = _planes(thin, FINE)
    ground, _ = _planes(rest[first_in_voxel(rest, COARSE.voxel_m)] if len(rest) else rest, COARSE)
    return ScanPlanes(fine, chosen(ground, np.abs(ground.normals[:, 2]) > LYING))


def chosen(cloud: PlanarCloud, keep: NDArray[np.bool_]) -> PlanarCloud:
    """Some of the planes."""
    points = cloud.points_m[keep]
    return PlanarCloud(points, cloud.normals[keep], cloud.tilts[keep], KDTree(points), cloud.reach_m)


def _planes(thin: NDArray[np.float64], scale: PlaneScale) -> tuple[PlanarCloud, NDArray[np.float64]]:
    """Planes among thinned points (n, 3), and the points (m, 3) where one was looked for and is not."""
    if len(thin) < MIN_NEIGHBOURS:
        none = np.empty((0, 3))
        return PlanarCloud(none, none, np.empty((0, 2, 3)), KDTree(none), scale.reach_m), thin
    at = np.sort(first_in_voxel(thin, scale.spacing_m))
    centred, weight = _neighbourhoods(thin, at, scale.radius_m)
    count = weight.sum(axis=1)
    covariance = np.einsum("nki,nkj,nk->nij", centred, centred, weight, optimize=True)
    values, vectors = np.linalg.eigh(covariance)
    flat = (count >= MIN_NEIGHBOURS) & (values[:, 0] < FLATNESS * values[:, 1])
    # a line of points along a scan column is flat in every direction: its plane means nothing
    flat &= values[:, 1] > 0.02 * values[:, 2]
    points, axes, spread = thin[at[flat]], vectors[flat], values[flat]
    variance = np.maximum(spread[:, 0], 0.0) / (count[flat] - PLANE_PARAMETERS)
    lengths = np.sqrt(variance[:, None] / spread[:, 1:])
    tilts = np.swapaxes(axes[:, :, 1:], 1, 2) * lengths[:, :, None]
    return PlanarCloud(points, axes[:, :, 0].copy(), tilts, KDTree(points), scale.reach_m), thin[at[~flat]]


def _neighbourhoods(
    points: NDArray[np.float64], at: NDArray[np.int64], radius_m: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Neighbours of some points minus their mean (n, k, 3), and 1 or 0 for neighbours that are there (n, k)."""
    distance, index = KDTree(points).query(
        points[at], k=min(NEIGHBOURS, len(points)), distance_upper_bound=radius_m
    )
    there = np.isfinite(distance)
    neighbours = points[np.where(there, index, 0)]
    weight = there.astype(np.float64)
    mean = np.einsum("nki,nk->ni", neighbours, weight) / weight.sum(axis=1)[:, None]
    return neighbours - mean[:, None, :], weight
