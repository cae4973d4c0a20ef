"""The planar points of a scan: where a neighbouring scan can be compared along a normal."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from tasks.geometry.voxels import first_in_voxel

VOXEL_M: Final = 0.2
"""Spacing after thinning; finer brings correlated points, not information."""

NEIGHBOURS: Final = 16
RADIUS_M: Final = 0.7
"""Neighbourhood of a normal: wide against 2 cm of noise, narrow against a shaft of 2 m radius."""

MIN_NEIGHBOURS: Final = 8
FLATNESS: Final = 0.05
"""Largest share of the smallest in the middle eigenvalue of a planar neighbourhood."""


@dataclass(frozen=True, slots=True)
class PlanarCloud:
    """Planar points (n, 3) and unit normals (n, 3) in the scanner frame, with their search tree."""

    points_m: NDArray[np.float64]
    normals: NDArray[np.float64]
    tree: KDTree


def planar_cloud(points_m: NDArray[np.float64]) -> PlanarCloud:
    """Thin a scan and keep the points whose neighbourhood is a plane; scanner frame throughout."""
    thin = points_m[first_in_voxel(points_m, VOXEL_M)]
    if len(thin) < MIN_NEIGHBOURS:
        return PlanarCloud(np.empty((0, 3)), np.empty((0, 3)), KDTree(np.empty((0, 3))))
    centred, weight = _neighbourhoods(thin)
    covariance = np.einsum("nki,nkj,nk->nij", centred, centred, weight, optimize=True)
    values, vectors = np.linalg.eigh(covariance)
    flat = (weight.sum(axis=1) >= MIN_NEIGHBOURS) & (values[:, 0] < FLATNESS * values[:, 1])
    # a line of points along a scan column is flat in every direction: its plane means nothing
    flat &= values[:, 1] > 0.02 * values[:, 2]
    points = thin[flat]
    return PlanarCloud(points, vectors[flat][:, :, 0].copy(), KDTree(points))


def _neighbourhoods(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Neighbours minus their mean (n, k, 3), and 1 or 0 for neighbours that are there (n, k)."""
    distance, index = KDTree(points).query(
        points, k=min(NEIGHBOURS, len(points)), distance_upper_bound=RADIUS_M
    )
    there = np.isfinite(distance)
    neighbours = points[np.where(there, index, 0)]
    weight = there.astype(np.float64)
    mean = np.einsum("nki,nk->ni", neighbours, weight) / weight.sum(axis=1)[:, None]
    return neighbours - mean[:, None, :], weight
