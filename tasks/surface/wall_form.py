"""How far the form of the wall may bend the lean: pieces of it, small and large, that are off the surface.

If the form of the wall keeps its sign over a distance, blocks smaller than that are not independent, and taking them so
makes the lean look too certain; larger blocks then give a larger variance, up to the size of the form. So several sizes
are tried, and the largest variance counts.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.surface.blocks import BlockSize, blocks_of_cells
from tasks.surface.cells import Cells
from tasks.surface.normal import Normal

BLOCK_SIZES: Final = (
    BlockSize(3, 3),
    BlockSize(6, 6),
    BlockSize(12, 9),
)
"""In cells: some 2.7 m by 15 degrees, 5.4 m by 30 degrees and 11 m by 45 degrees on a shaft of 100 m. Of larger pieces
too few are left once axis, radius and harmonics are taken out."""

LEAST_FREEDOM: Final = 0.2
"""Share of the blocks that the unknowns must leave."""

SIGNIFICANT: Final = 2.0
"""Form counts from this many standard deviations of its own statistic on: noise alone must not look like form."""


def wall_form(cells: Cells, normal: Normal, pull: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (k, k) that the form of the wall causes in what follows the cells by (k, c), such as the lean vector.

    Parameters
    ----------
    cells : Cells
        Residuals of the surface at its minimum.
    normal : Normal
        Its normal equations.
    pull : (k, c) array
        How that follows the residuals of the cells (``Normal.pull``); all in one unit, since their sum is compared.
    """
    residual_m = normal.without_poses(cells.residual_m)
    largest = np.zeros((len(pull), len(pull)))
    for size in BLOCK_SIZES:
        block = blocks_of_cells(cells, size)
        variance = _form_variance(cells.moved(cells.residual_m - residual_m), normal, block)
        of_blocks = np.stack([np.bincount(block, row) for row in pull])
        found = variance * of_blocks @ of_blocks.T
        largest = found if np.trace(found) > np.trace(largest) else largest
    return np.asarray(largest)


def _form_variance(cells: Cells, normal: Normal, block: NDArray[np.intp]) -> float:
    """Variance of what a block of the wall is off the surface, square metres; what the fit took out is put back.

    With m the mean residuals of the blocks, H what the fit makes of a form f of the blocks, and W their weights, the mean
    of m' W m is t^2 tr((I - H)' W (I - H)) plus that of the noise.
    """
    n = int(block.max()) + 1
    weight = np.bincount(block, normal.weight)
    kept = weight > 0.0
    safe = np.where(kept, weight, 1.0)
    mean = np.bincount(block, normal.weight * cells.residual_m) / safe
    weighted = normal.design * normal.weight[:, None]
    sums = np.stack([np.bincount(block, column, minlength=n) for column in weighted.T], axis=1)
    hat = (sums / safe[:, None]) @ normal.covariance() @ sums.T
    left = np.eye(n) - hat
    freedom = float(np.sum(weight[:, None] * left**2))
    if freedom < LEAST_FREEDOM * float(weight.sum()):
        return 0.0
    # noise: a block's own variance is 1 / weight where the points of a block have nothing in common
    noise_m2 = np.bincount(block, normal.weight**2 * cells.robust_price / cells.weight) / safe**2
    expected = float(np.sum(weight[:, None] * left**2 * noise_m2))
    excess = float(weight @ mean**2) - expected
    scatter = expected * float(np.sqrt(2.0 / max(np.count_nonzero(kept) * freedom / weight.sum(), 1.0)))
    return excess / freedom if excess > SIGNIFICANT * scatter else 0.0
