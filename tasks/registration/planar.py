"""The planar points of a scan: where a neighbouring scan can be compared along a normal."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from tasks.geometry.voxels import first_in_voxel


@dataclass(frozen=True, slots=True)
class PlaneScale:
    """At what scale planes are looked for, metres.

    ``voxel_m`` is the spacing after thinning; ``radius_m`` the neighbourhood of a normal; a plane holds at least
    ``reach_m`` from the point that stands for it.
    """

    voxel_m: float
    radius_m: float
    reach_m: float


FINE: Final = PlaneScale(voxel_m=0.2, radius_m=0.7, reach_m=0.5)
"""Shaft and facades: finer brings correlated points, not information; wide against 2 cm of noise, narrow against a
shaft of 2 m radius."""

COARSE: Final = PlaneScale(voxel_m=0.8, radius_m=4.0, reach_m=3.0)
"""The ground: from a tripod it is seen at a grazing angle, at 100 m its scan lines lie metres apart."""

LYING: Final = 0.7
"""Smallest share of up in the normal of ground."""

NEIGHBOURS: Final = 16
MIN_NEIGHBOURS: Final = 8
FLATNESS: Final = 0.05
"""Largest share of the smallest in the middle eigenvalue of a planar neighbourhood."""

PLANE_PARAMETERS: Final = 3
THREADS: Final = 4
"""Scans are worked on side by side; the result does not depend on how many."""


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
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(planes_of_scan, scans_m))


def planes_of_scan(points_m: NDArray[np.float64]) -> ScanPlanes:
    """Planes of a scan (n, 3): fine ones, and where there is none, those of the ground."""
    thin = points_m[first_in_voxel(points_m, FINE.voxel_m)]
    fine, is_planar = _planes(thin, FINE)
    rest = thin[~is_planar]
    ground, _ = _planes(rest[first_in_voxel(rest, COARSE.voxel_m)] if len(rest) else rest, COARSE)
    return ScanPlanes(fine, chosen(ground, np.abs(ground.normals[:, 2]) > LYING))


def chosen(cloud: PlanarCloud, keep: NDArray[np.bool_]) -> PlanarCloud:
    """Some of the planes."""
    points = cloud.points_m[keep]
    return PlanarCloud(points, cloud.normals[keep], cloud.tilts[keep], KDTree(points), cloud.reach_m)


def _planes(thin: NDArray[np.float64], scale: PlaneScale) -> tuple[PlanarCloud, NDArray[np.bool_]]:
    """Planes among thinned points (n, 3), and which of the points (n,) have one."""
    if len(thin) < MIN_NEIGHBOURS:
        none = np.empty((0, 3))
        return PlanarCloud(none, none, np.empty((0, 2, 3)), KDTree(none), scale.reach_m), np.zeros(
            len(thin), bool
        )
    centred, weight = _neighbourhoods(thin, scale.radius_m)
    count = weight.sum(axis=1)
    covariance = np.einsum("nki,nkj,nk->nij", centred, centred, weight, optimize=True)
    values, vectors = np.linalg.eigh(covariance)
    flat = (count >= MIN_NEIGHBOURS) & (values[:, 0] < FLATNESS * values[:, 1])
    # a line of points along a scan column is flat in every direction: its plane means nothing
    flat &= values[:, 1] > 0.02 * values[:, 2]
    points, axes, spread = thin[flat], vectors[flat], values[flat]
    variance = np.maximum(spread[:, 0], 0.0) / (count[flat] - PLANE_PARAMETERS)
    lengths = np.sqrt(variance[:, None] / spread[:, 1:])
    tilts = np.swapaxes(axes[:, :, 1:], 1, 2) * lengths[:, :, None]
    return PlanarCloud(points, axes[:, :, 0].copy(), tilts, KDTree(points), scale.reach_m), flat


def _neighbourhoods(
    points: NDArray[np.float64], radius_m: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Neighbours minus their mean (n, k, 3), and 1 or 0 for neighbours that are there (n, k)."""
    distance, index = KDTree(points).query(
        points, k=min(NEIGHBOURS, len(points)), distance_upper_bound=radius_m
    )
    there = np.isfinite(distance)
    neighbours = points[np.where(there, index, 0)]
    weight = there.astype(np.float64)
    mean = np.einsum("nki,nk->ni", neighbours, weight) / weight.sum(axis=1)[:, None]
    return neighbours - mean[:, None, :], weight
