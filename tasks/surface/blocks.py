"""The wall is never as smooth as its model: what pieces of it are off the surface beyond the noise of their points.

All stations see the same wall, so a piece is one of the wall, whoever saw it. Its mean residual has the variance v of its
points and, beyond it, the variance t of the wall's own form there. A dense piece is then worth no more than 1/t, however
many points it has; and the lean carries the form of the wall, whichever the points.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.surface.cells import SECTORS, Cells

SECTORS_OF_BLOCK: Final = 3
"""15 degrees."""

BLOCK_CUT: Final = 7.0
"""Blocks this many standard deviations off the surface do not count: a bracket, a patch, a cable along the shaft."""


def _price_at_normal(cut: float) -> float:
    """Variance per unit of weight of Tukey's biweight on normal residuals, in sigmas, by quadrature up to the cut."""
    nodes, shares = np.polynomial.legendre.leggauss(80)
    u = cut * nodes
    density = shares * cut * np.exp(-(u**2) / 2.0) / np.sqrt(2.0 * np.pi)
    ratio = nodes**2
    weight = (1.0 - ratio) ** 2
    influence = float(density @ (weight * u) ** 2)
    slope = float(density @ ((1.0 - ratio) * (1.0 - 5.0 * ratio)))
    return float(density @ weight) * influence / slope**2


BLOCK_PRICE: Final = _price_at_normal(BLOCK_CUT)
"""What the robust weights of the blocks leave of their information, over what those weights are."""

MEDIAN_CHI2_1: Final = 0.45493642311957
"""Median of chi-square with one degree of freedom."""

BISECTIONS: Final = 50


@dataclass(frozen=True, slots=True, eq=False)
class Blocks:
    """Blocks of cells.

    Attributes
    ----------
    common_sigma_m : float
        Standard deviation of what the points of a block have in common, metres.
    share : (c,) array
        What is left of the information of each cell: well below 1 where the points of a block err together, 0 in blocks
        that lie off the surface.
    n_off : int
        Blocks off the surface.
    """

    common_sigma_m: float
    share: NDArray[np.float64]
    n_off: int


@dataclass(frozen=True, slots=True)
class BlockSize:
    """How many cells a block has, in height and around."""

    heights: int
    sectors: int


def blocks_of_cells(cells: Cells, size: BlockSize) -> NDArray[np.intp]:
    """Number of the block (c,) that each cell belongs to, from 0 without gaps."""
    key = cells.height // size.heights * SECTORS + cells.sector // size.sectors
    return np.asarray(np.unique(key, return_inverse=True)[1], dtype=np.intp)


def weigh_blocks(cells: Cells, heights_of_block: int, n_unknowns: int) -> Blocks:
    """Estimate what the points of a block have in common, from the residuals of a surface with that many unknowns."""
    of_cell = blocks_of_cells(cells, BlockSize(heights_of_block, SECTORS_OF_BLOCK))
    weight = np.bincount(of_cell, cells.weight)
    mean = np.bincount(of_cell, cells.weight * cells.residual_m) / weight
    variance = cells.robust_price / weight
    # what the unknowns of the surface took out of the residuals
    freedom = max(1.0 - n_unknowns / len(weight), 0.1)
    common = _robust_common(mean, variance, freedom)
    off = (mean / BLOCK_CUT) ** 2 >= variance + common
    common = common_variance(mean[~off], variance[~off], freedom)
    ratio = np.minimum(mean**2 / (BLOCK_CUT**2 * (variance + common)), 1.0)
    share = (1.0 - ratio) ** 2 / BLOCK_PRICE * variance / (variance + common)
    return Blocks(float(np.sqrt(common)), share[of_cell], int(np.count_nonzero(ratio >= 1.0)))


def common_variance(mean: NDArray[np.float64], variance: NDArray[np.float64], freedom: float) -> float:
    """Common variance by moments (DerSimonian & Laird 1986, Controlled Clinical Trials 7), or 0.

    Parameters
    ----------
    mean, variance : (b,) arrays
        Mean residuals of blocks, metres, and the variances of their noise, square metres.
    freedom : float
        Redundancy of the average block.
    """
    weight = 1.0 / variance
    excess = float(weight @ mean**2) - freedom * len(mean)
    return max(excess / (freedom * float(weight.sum())), 0.0)


def _robust_common(mean: NDArray[np.float64], variance: NDArray[np.float64], freedom: float) -> float:
    """Common variance at which the squared residuals have the median of chi-square, or 0."""
    low, high = 0.0, float(np.max(mean**2)) / MEDIAN_CHI2_1
    wanted = MEDIAN_CHI2_1 * freedom
    if float(np.median(mean**2 / variance)) <= wanted:
        return 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if float(np.median(mean**2 / (variance + middle))) > wanted:
            low = middle
        else:
            high = middle
    return high
