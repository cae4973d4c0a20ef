"""Bootstrap of the slices of an axis: a check of the covariance that is stated."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

LEAST_CENTRES: Final = 8
RESAMPLES: Final = 400
SEED: Final = 20250314


def bootstrap_slices(
    centres_m: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Covariance (2, 2) of the lean over resamples of the centres (m, 3) with their weights (m,).

    None with fewer than ``LEAST_CENTRES`` centres that have a weight.
    """
    used = weights > 0.0
    m = int(np.count_nonzero(used))
    if m < LEAST_CENTRES:
        return None
    rng = np.random.default_rng(SEED)
    counts = rng.multinomial(m, np.full(m, 1.0 / m), size=RESAMPLES) * weights[used]
    z = centres_m[used, 2] - centres_m[used, 2].mean()
    xy = centres_m[used, :2] - centres_m[used, :2].mean(axis=0)
    total = counts.sum(axis=1)
    mean_z = counts @ z / total
    spread = counts @ z**2 - total * mean_z**2
    good = spread > 1e-9 * total * float(z @ z) / m
    leans = (counts @ (z[:, None] * xy) - mean_z[:, None] * (counts @ xy)) / np.where(good, spread, 1.0)[
        :, None
    ]
    # two coefficients of m were adjusted
    return np.asarray(np.cov(leans[good].T) * m / (m - 2))
