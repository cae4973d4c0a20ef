"""The pieces of a map of the surface: which points belong to which, and their robust means."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.robust import MAD_TO_SIGMA, TUKEY_1D, mad_sigma

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


CHUNK: Final = 1 << 17
"""Points looked at at once."""


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


OfRows = Callable[[slice], NDArray[np.float64]]
"""Values of the points of some rows: looked at in chunks, so that nothing that is made of them on the way is kept."""


@dataclass(frozen=True, slots=True, eq=False)
class CellPoints:
    """Which points (n,) belong to which piece, and how many points (c, s) of every piece each station has."""

    cell: NDArray[np.uint16]
    counts: NDArray[np.int64]

    @property
    def n_points(self) -> NDArray[np.int64]:
        """Points (c,) of every piece."""
        return np.asarray(self.counts.sum(axis=1))

    @property
    def shares(self) -> NDArray[np.float64]:
        """Share (c, s) of every station in the points of every piece."""
        table = self.counts.astype(np.float64)
        return np.asarray(table / np.maximum(table.sum(axis=1, keepdims=True), 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class CellMeans:
    """Robust means of the points of pieces.

    Attributes
    ----------
    n_points : (c,) array
        Points of every piece.
    mean : (c,) array
        Of a piece without points it means nothing.
    sigma : (c,) array or None
        Standard deviation of the means, the points taken as independent; None where there are too few points
        to tell their scatter.
    about, reach : (c,) arrays
        The last weights: Tukey's biweight of what values are off ``about``, up to ``reach``, which may be infinite.
    """

    n_points: NDArray[np.int64]
    mean: NDArray[np.float64]
    sigma: NDArray[np.float64] | None
    about: NDArray[np.float64]
    reach: NDArray[np.float64]

    def mean_of(self, others: OfRows, values: OfRows, cell: NDArray[np.uint16]) -> NDArray[np.float64]:
        """Means (c,) of other values of the same points in pieces (n,), with the weights of the values."""
        from tasks.map_kernel import add_weighted  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

        sums = np.zeros((len(self.n_points), 2))
        for rows in chunks_of(len(cell)):
            add_weighted(values(rows), others(rows), cell[rows], self.about, self.reach, sums)
        return np.asarray(sums[:, 1] / np.where(sums[:, 0] > 0.0, sums[:, 0], 1.0))


def chunks_of(n: int) -> Iterator[slice]:
    """Rows of n points that are looked at at once."""
    for start in range(0, n, CHUNK):
        yield slice(start, min(start + CHUNK, n))


def robust_means(values: OfRows, cell: NDArray[np.uint16], n_points: NDArray[np.int64]) -> CellMeans:
    """Average values of points by piece (n,) with Tukey's weights about the median of each piece.

    A piece with few points cannot tell its own strays: its scale is the median of those of the pieces with more, or, where
    no piece has enough, that of the differences within all of them. With a handful of points in all, means are plain.
    """
    from tasks.map_kernel import find_scales, weigh_means  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    ends = np.concatenate([[0], np.cumsum(n_points)])
    together = _together(values, cell, ends)
    own = n_points >= LEAST_FOR_SCALE
    about, mean = np.zeros(len(n_points)), np.zeros(len(n_points))
    scale = np.maximum(MAD_TO_SIGMA * find_scales(together, ends, LEAST_FOR_SCALE, about), SMALLEST_SIGMA_M)
    usual = float(np.median(scale[own])) if own.any() else _scale_of_pairs(together, ends)
    reach = TUKEY_1D * np.where(own, scale, usual)
    influence, slope = weigh_means(together, ends, reach, STEPS, about, mean).T
    sigma = usual / np.sqrt(np.maximum(n_points, 1))
    # influence over its slope (Huber 1981), of n - 1 free points
    n = n_points[own]
    sigma[own] = np.sqrt(influence[own] * n / (n - 1)) / slope[own]
    return CellMeans(n_points, mean, sigma if np.isfinite(usual) else None, about, reach)


def _together(values: OfRows, cell: NDArray[np.uint16], ends: NDArray[np.int64]) -> NDArray[np.float64]:
    """Values (n,) piece after piece."""
    from tasks.map_kernel import put_together  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    together, places = np.empty(len(cell)), ends[:-1].copy()
    for rows in chunks_of(len(cell)):
        put_together(values(rows), cell[rows], places, together)
    return together


def _scale_of_pairs(together: NDArray[np.float64], ends: NDArray[np.int64]) -> float:
    """Scale of values (n,), piece after piece, from neighbours within a piece; infinite with too few of them."""
    of_two = np.isin(np.arange(1, len(together)), ends)
    apart = np.diff(together)[~of_two]
    if len(apart) < LEAST_FOR_SCALE:
        return np.inf
    return max(mad_sigma(apart) / float(np.sqrt(2.0)), SMALLEST_SIGMA_M)
