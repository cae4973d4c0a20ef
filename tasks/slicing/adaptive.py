"""Slices just thick enough that every centre reaches a wanted sigma."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.slicing.center_information import (
    CenterSums,
    RingPoints,
    center_variances,
    sum_layers,
)
from tasks.slicing.linearity import ThicknessLimit
from tasks.slicing.scheme import AdaptiveCut

LAYERS_PER_SLICE: Final = 10
"""Slices are whole layers: a tenth of the least thickness, so that the wanted sigma is met to 5 % even there."""

MOST_LAYERS: Final = 200_000
"""More layers than this take memory for nothing: on 1000 m they are 5 mm high."""

AT_ONCE: Final = 64
"""Thicknesses that are tried in one go."""


@dataclass(frozen=True, slots=True, eq=False)
class AdaptiveSlices:
    """Slices that stand on one another from the lower end of a shaft to the upper.

    Attributes
    ----------
    edges_m : (m + 1,) array
        Ends of the m slices, ascending, site frame, metres; empty where the shaft is lower than the least thickness.
    sigma_m : (m,) array
        Expected standard deviation of the less certain component of each centre, metres; infinite where the points
        cannot give one.
    """

    edges_m: NDArray[np.float64]
    sigma_m: NDArray[np.float64]


def adaptive_slices(
    chunks: Iterable[RingPoints], cut: AdaptiveCut, shaft_z_m: tuple[float, float], limit: ThicknessLimit
) -> AdaptiveSlices:
    """Cut a shaft from the bottom up, each slice just thick enough for the wanted sigma of its centre.

    The slices stand on one another: every point of the shaft is used, once. They are thin where points are dense and
    lie all around, thick where they are few or lie on an arc, so their distance follows the points as their thickness
    does. Where even the thickest slice does not reach the wanted sigma it stays, and its larger sigma shows it. What is
    left at the upper end and does not reach it joins the last slice, or shares with it where both are too thick for one.

    The variance of a centre is that of a circle with its radius free (``center_variances``), from the geometry and
    the sigma of the points alone; it falls in proportion to the thickness where nothing changes with height.

    Parameters
    ----------
    chunks : iterable of RingPoints
        The points of the shaft, in one piece or several.
    cut : AdaptiveCut
        The wanted sigma, and the bounds of the thickness.
    shaft_z_m : (lo, hi)
        Ends of the shaft in the site frame, metres, lo < hi.
    limit : ThicknessLimit
        How thick a slice may be before the shaft within it is no longer straight; never below the least thickness.

    Raises
    ------
    ShapeError
        If ``shaft_z_m`` is not ascending and finite.

    References
    ----------
    docs/estimators.md, adaptive slices.
    """
    low, high = float(shaft_z_m[0]), float(shaft_z_m[1])
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise ShapeError(f"adaptive_slices needs shaft_z_m (lo, hi) with lo < hi, got ({low:g}, {high:g})")
    if high - low < cut.least_thickness_m:
        return AdaptiveSlices(np.empty(0), np.empty(0))
    step_m = max(cut.least_thickness_m / LAYERS_PER_SLICE, (high - low) / MOST_LAYERS)
    grid_m = np.linspace(low, high, int(np.ceil((high - low) / step_m)) + 1)
    walk = _Walk(sum_layers(chunks, grid_m), *_bounds(cut, limit, grid_m))
    edges = _edges(walk, cut.sigma_center_m**2)
    return AdaptiveSlices(grid_m[edges], np.sqrt(walk.variances(edges[:-1], edges[1:])))


def _bounds(
    cut: AdaptiveCut, limit: ThicknessLimit, grid_m: NDArray[np.float64]
) -> tuple[int, NDArray[np.intp]]:
    """Least thickness, and the greatest by layer, in layers."""
    step_m = grid_m[1] - grid_m[0]
    least = max(round(cut.least_thickness_m / step_m), 1)
    most_m = np.minimum(limit.at((grid_m[1:] + grid_m[:-1]) / 2), cut.most_thickness_m)
    return least, np.maximum(np.rint(most_m / step_m).astype(np.intp), least)


@dataclass(frozen=True, slots=True, eq=False)
class _Walk:
    """A shaft in thin layers, and how many of them a slice may have."""

    sums: CenterSums
    least: int
    most: NDArray[np.intp]

    def variances(self, begins: NDArray[np.intp], ends: NDArray[np.intp]) -> NDArray[np.float64]:
        """Variances (m,) of the less certain component of slices from layers (m,) to layers (m,)."""
        return center_variances(self.sums.between(begins, ends))

    def most_from(self, begin: int) -> int:
        """Layers a slice from ``begin`` may have: no more than any height within it allows."""
        most = min(int(self.most[begin]), len(self.most) - begin)
        return min(most, max(int(self.most[begin : begin + most].min()), self.least))

    def edges(self, wanted_m2: float) -> list[int]:
        """Layers at which slices begin, from the bottom, and the last one's end."""
        edges = [0]
        while edges[-1] < len(self.most):
            edges.append(edges[-1] + self._thickness(edges[-1], wanted_m2))
        return edges

    def _thickness(self, begin: int, wanted_m2: float) -> int:
        most = self.most_from(begin)
        for first in range(self.least, most + 1, AT_ONCE):
            tried = np.arange(first, min(first + AT_ONCE, most + 1))
            enough = np.flatnonzero(self.variances(np.full_like(tried, begin), begin + tried) <= wanted_m2)
            if enough.size:
                return int(tried[enough[0]])
        return most


def _edges(walk: _Walk, wanted_m2: float) -> NDArray[np.intp]:
    """Edges of slices in layers; what is left at the upper end joins the last slice, or shares with it."""
    edges = np.array(walk.edges(wanted_m2), dtype=np.intp)
    if len(edges) < 3 or walk.variances(edges[-2:-1], edges[-1:])[0] <= wanted_m2:
        return edges
    if edges[-1] - edges[-3] <= walk.most_from(int(edges[-3])):
        return np.delete(edges, -2)
    edges[-2] = (edges[-3] + edges[-1]) // 2
    return edges
