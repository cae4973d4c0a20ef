"""The pieces of a map of the surface: which points belong to which, and their robust means."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.robust import mad_sigma, tukey_weights

BAND_M: Final = 2.5
"""Height of a band, where that makes neither too few nor too many of them."""

FEWEST_BANDS: Final = 10
MOST_BANDS: Final = 40

SECTORS: Final = 36
SECTOR_DEG: Final = 10.0

LEAST_FOR_SCALE: Final = 10
"""Points of a piece whose own scatter says how good its mean is; below it the usual scatter of the others does."""

STEPS: Final = 4
"""Reweightings of a mean: it then moves by less than a hundredth of its standard deviation."""

SMALLEST_SIGMA_M: Final = 1e-9
"""Scale of noise-free points: a zero would give no weights."""


@dataclass(frozen=True, slots=True, eq=False)
class MapGrid:
    """Bands between rising heights (b + 1,), each with ``SECTORS`` sectors clockwise from grid north."""

    z_edges_m: NDArray[np.float64]

    @property
    def n_bands(self) -> int:
        """Number of bands."""
        return len(self.z_edges_m) - 1

    @property
    def size(self) -> int:
        """Number of pieces."""
        return self.n_bands * SECTORS

    @property
    def z_m(self) -> NDArray[np.float64]:
        """Middles (b,) of the bands, metres."""
        return np.array([0.5 * (low + high) for low, high in pairwise(self.z_edges_m)])

    @property
    def band(self) -> NDArray[np.intp]:
        """Band (c,) of every piece."""
        return np.repeat(np.arange(self.n_bands), SECTORS)

    @property
    def azimuth_deg(self) -> NDArray[np.float64]:
        """Middle (c,) of the sector of every piece, degrees."""
        return np.tile(SECTOR_DEG * (np.arange(SECTORS) + 0.5), self.n_bands)

    def cells_of(self, z_m: NDArray[np.float64], ray_m: NDArray[np.float64]) -> NDArray[np.intp]:
        """Pieces (n,) of points within the bands, from their heights (n,) and where they are from the axis (n, 2)."""
        band = np.searchsorted(self.z_edges_m, z_m, side="right") - 1
        turns = np.arctan2(ray_m[:, 0], ray_m[:, 1]) / (2.0 * np.pi)
        sector = np.floor(turns * SECTORS).astype(np.intp) % SECTORS
        return np.asarray(np.clip(band, 0, self.n_bands - 1) * SECTORS + sector)


def map_grid(shaft_z_m: tuple[float, float]) -> MapGrid:
    """Even bands over a shaft, of about ``BAND_M``: ``FEWEST_BANDS`` to ``MOST_BANDS``.

    Raises
    ------
    ShapeError
        If the heights do not rise.
    """
    low, high = shaft_z_m
    if not low < high:
        raise ShapeError(f"a map needs heights that rise; got {shaft_z_m}")
    n_bands = int(np.clip(round((high - low) / BAND_M), FEWEST_BANDS, MOST_BANDS))
    return MapGrid(np.linspace(low, high, n_bands + 1))


@dataclass(frozen=True, slots=True, eq=False)
class CellMeans:
    """Robust means of the points of pieces.

    Attributes
    ----------
    n_points : (c,) array
        Points of every piece.
    weight : (n,) array
        Robust weight of every point in the mean of its piece.
    mean : (c,) array
        Of a piece without points it means nothing.
    sigma : (c,) array or None
        Standard deviation of the means, the points taken as independent; None where there are too few points
        to tell their scatter.
    """

    n_points: NDArray[np.intp]
    weight: NDArray[np.float64]
    mean: NDArray[np.float64]
    sigma: NDArray[np.float64] | None

    def mean_of(self, values: NDArray[np.float64], cell: NDArray[np.intp]) -> NDArray[np.float64]:
        """Means (c,) of other values (n,) of the same points in pieces (n,), with the same weights."""
        total = np.bincount(cell, self.weight, minlength=len(self.n_points))
        summed = np.bincount(cell, self.weight * values, minlength=len(self.n_points))
        return np.asarray(summed / np.where(total > 0.0, total, 1.0))


def robust_means(values: NDArray[np.float64], cell: NDArray[np.intp], n_cells: int) -> CellMeans:
    """Average values (n,) by piece (n,) with Tukey's weights about the median of each piece.

    A piece with few points cannot tell its own strays: its scale is the median of those of the pieces with more, or, where
    no piece has enough, that of the differences within all of them. With a handful of points in all, means are plain.
    """
    order = np.argsort(cell, kind="stable")
    n_points = np.bincount(cell, minlength=n_cells)
    ends = np.concatenate([[0], np.cumsum(n_points)])
    rows_of = {int(c): order[ends[c] : ends[c + 1]] for c in np.flatnonzero(n_points)}
    own = n_points >= LEAST_FOR_SCALE
    scale = np.zeros(n_cells)
    for number in np.flatnonzero(own):
        of_cell = values[rows_of[int(number)]]
        scale[number] = max(mad_sigma(of_cell - np.median(of_cell)), SMALLEST_SIGMA_M)
    usual = float(np.median(scale[own])) if own.any() else _scale_of_pairs(values[order], cell[order])
    scale[~own] = usual
    weight, mean, sigma = np.empty(len(values)), np.zeros(n_cells), usual / np.sqrt(np.maximum(n_points, 1))
    for place, rows in rows_of.items():
        weight[rows], mean[place] = _robust_mean(values[rows], float(scale[place]))
        if own[place]:
            sigma[place] = _sigma_of_mean(values[rows] - mean[place], weight[rows])
    return CellMeans(n_points, weight, mean, sigma if np.isfinite(usual) else None)


def _scale_of_pairs(values: NDArray[np.float64], cell: NDArray[np.intp]) -> float:
    """Scale of values (n,), sorted by piece, from neighbours within a piece; infinite with too few of them."""
    apart = np.diff(values)[np.diff(cell) == 0]
    if len(apart) < LEAST_FOR_SCALE:
        return np.inf
    return max(mad_sigma(apart) / float(np.sqrt(2.0)), SMALLEST_SIGMA_M)


def _robust_mean(values: NDArray[np.float64], scale: float) -> tuple[NDArray[np.float64], float]:
    """Weights (n,) and mean of the values of a piece; an infinite scale makes all alike."""
    mean = float(np.median(values))
    for _ in range(STEPS):
        weight = tukey_weights(values - mean, scale)
        if not weight.any():
            # two or three points that contradict each other
            weight = np.ones(len(values))
        mean = float(weight @ values / weight.sum())
    return weight, mean


def _sigma_of_mean(residuals: NDArray[np.float64], weight: NDArray[np.float64]) -> float:
    """Standard deviation of a weighted mean: influence over its slope (Huber 1981), of n - 1 free points."""
    n = len(residuals)
    root = np.sqrt(weight)
    # with u^2 = 1 - root the derivative of Tukey's influence is (1 - u^2) (1 - 5 u^2)
    slope = float(np.sum(root * (5.0 * root - 4.0)))
    return float(np.sqrt(np.sum((weight * residuals) ** 2) * n / (n - 1)) / slope)
