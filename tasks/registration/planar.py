"""The planar points of a scan: where a neighbouring scan can be compared along a normal."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.neighbours import spread_of_neighbours
from tasks.geometry.side_by_side import side_by_side
from tasks.geometry.voxels import first_in_voxel
from tasks.registration.even_sample import Cloud, sampled

if TYPE_CHECKING:
    from scipy.spatial import KDTree


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

MOST_POINTS: Final = 2_000_000
"""Points of a scan that are looked at; of more an even sample is taken, so that time and memory are bounded. More brought
no better poses on simulated sites (docs/decisions/0020)."""


@dataclass(frozen=True, slots=True)
class PlanarCloud:
    """Planar points (n, 3) and unit normals (n, 3) in one frame, with their search tree.

    ``tilts`` (n, 2, 3) are two tangents of every plane, each as long as the standard deviation (rad) by which the
    normal may lean that way: what the noise of the points leaves open. A plane holds ``reach_m`` around its point.
    """

    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    tilts: NDArray[np.float64]
    tree: "KDTree"
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


def scan_planes(scans_m: Sequence[Cloud]) -> list[ScanPlanes]:
    """Planes of several scans (n_i, 3), each in its own scanner frame."""
    return side_by_side(planes_of_scan, scans_m)


def planes_of_scan(points_m: Cloud) -> ScanPlanes:
    """Planes of a scan (n, 3): fine ones, and where there is none, those of the ground.

    Of more than MOST_POINTS points an even sample is taken: time and memory do not grow any further.
    """
    fine, rest = _planes(_thin(sampled(points_m, MOST_POINTS), FINE), FINE)
    ground, _ = _planes(_thin(rest, COARSE), COARSE, lying=LYING)
    return ScanPlanes(fine, ground)


def _thin(points_m: NDArray[np.float64], scale: PlaneScale) -> NDArray[np.float64]:
    return points_m[first_in_voxel(points_m, scale.voxel_m)]


def chosen(cloud: PlanarCloud, keep: NDArray[np.bool_]) -> PlanarCloud:
    """Some of the planes."""
    from scipy.spatial import KDTree  # noqa: PLC0415 (slow to import)

    points = cloud.points_m[keep]
    return PlanarCloud(points, cloud.normals[keep], cloud.tilts[keep], KDTree(points), cloud.reach_m)


def _planes(
    thin: NDArray[np.float64], scale: PlaneScale, lying: float = -1.0
) -> tuple[PlanarCloud, NDArray[np.float64]]:
    """Planes among thinned points (n, 3) with more than a share of up in the normal, and the points (m, 3) of no plane."""
    from scipy.spatial import KDTree  # noqa: PLC0415 (slow to import)

    if len(thin) < MIN_NEIGHBOURS:
        none = np.empty((0, 3))
        return PlanarCloud(none, none, np.empty((0, 2, 3)), KDTree(none), scale.reach_m), thin
    at = first_in_voxel(thin, scale.spacing_m)
    spread = spread_of_neighbours(thin, at, scale.radius_m, (MIN_NEIGHBOURS, NEIGHBOURS))
    values, up = spread.values, np.abs(spread.vectors[:, 2, 0])
    # a line of points along a scan column is flat in every direction: its plane means nothing
    flat = (values[:, 0] < FLATNESS * values[:, 1]) & (values[:, 1] > 0.02 * values[:, 2])
    is_plane = spread.enough.copy()
    is_plane[spread.enough] = flat
    kept = flat & (up > lying)
    points, axes, values = thin[at[spread.enough][kept]], spread.vectors[kept], values[kept]
    variance = np.maximum(values[:, 0], 0.0) / (spread.count[kept] - PLANE_PARAMETERS)
    lengths = np.sqrt(variance[:, None] / values[:, 1:])
    tilts = np.swapaxes(axes[:, :, 1:], 1, 2) * lengths[:, :, None]
    return PlanarCloud(points, axes[:, :, 0].copy(), tilts, KDTree(points), scale.reach_m), thin[
        at[~is_plane]
    ]
