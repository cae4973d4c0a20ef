"""A cloud as a sampled surface: normals, local spacing and noise, all in its own terms."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.spatial import KDTree

NEIGHBOURS: Final = (10, 20, 40)
"""Sizes of a neighbourhood, tried in turn: scan lines need a wide one before it holds more than a line."""

LINE: Final = 0.05
"""A neighbourhood whose middle eigenvalue is below this share of the largest is a line and has no normal."""

FLATNESS: Final = 0.2
"""Largest share of the smallest in the middle eigenvalue where a normal means anything."""

WIDEST_AREA: Final = 8.0
"""A point stands for at most this many times the median area, so that stray points do not fill a sample."""


@dataclass(frozen=True, slots=True)
class Surface:
    """Points (n, 3) that have a normal (n, 3), with the length (n,) that each stands for.

    ``noise`` is the typical distance of a point from the plane of its neighbours, ``spacing`` the typical distance to
    the sixth neighbour. Any unit.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    lengths: NDArray[np.float64]
    noise: float
    spacing: float
    tree: "KDTree"

    def sample(self, n: int) -> NDArray[np.int64]:
        """At most ``n`` indices, taken evenly by area: neither the frame nor chance has a say."""
        if n >= len(self.points):
            return np.arange(len(self.points))
        share = np.cumsum(np.minimum(self.lengths**2, WIDEST_AREA * np.median(self.lengths) ** 2))
        wanted = (np.arange(n) + 0.5) * share[-1] / n
        return np.unique(np.searchsorted(share, wanted)).clip(max=len(share) - 1)


def surface_of(points: NDArray[np.float64]) -> Surface:
    """Find normals, spacing and noise of distinct points (n, 3); points without a normal are left out.

    Fewer than eleven points have no surface.
    """
    from scipy.spatial import KDTree  # noqa: PLC0415 (slow to import)

    if len(points) <= NEIGHBOURS[0]:
        return Surface(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), 0.0, 0.0, KDTree(np.empty((0, 3))))
    distance, index = KDTree(points).query(points, k=min(NEIGHBOURS[-1] + 1, len(points)))
    normals = np.zeros_like(points)
    depth = np.full(len(points), np.nan)
    for size in NEIGHBOURS:
        todo = np.flatnonzero(np.isnan(depth))
        if not len(todo):
            break
        neighbours = points[index[todo, : size + 1]]
        centred = neighbours - neighbours.mean(axis=1, keepdims=True)
        values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred) / centred.shape[1])
        flat = (values[:, 1] > LINE * values[:, 2]) & (values[:, 0] < FLATNESS * values[:, 1])
        normals[todo[flat]] = vectors[flat][:, :, 0]
        depth[todo[flat]] = np.sqrt(np.maximum(values[flat, 0], 0.0))
    there = np.isfinite(depth)
    lengths = distance[there, min(6, distance.shape[1] - 1)]
    noise = float(np.median(depth[there])) if there.any() else 0.0
    spacing = float(np.median(lengths)) if there.any() else 0.0
    return Surface(points[there], normals[there], lengths, noise, spacing, KDTree(points[there]))


def thinned(surface: Surface, n: int) -> Surface:
    """The same surface from ``n`` of its points, with normals of the wider neighbourhoods that this makes."""
    return surface_of(surface.points[surface.sample(n)])
