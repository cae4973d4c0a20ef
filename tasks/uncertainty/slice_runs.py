"""Neighbouring slices of a wall err together: what runs of slices say of the covariance of their axis."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

LEAST_CENTRES: Final = 24
"""With fewer centres there are too few runs."""

RUNS: Final = (2, 4, 8)
"""Lengths of runs, in slices."""

LEAST_RUNS: Final = 10

BENT_ORDER: Final = 3
"""Bending up to a cubic is the shape of the axis, and no error."""

SIGNIFICANT: Final = 2.0
"""Runs count from this many standard deviations of their own statistic on."""


def form_of_slices(
    centres_m: NDArray[np.float64], levers: NDArray[np.float64], stated: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Covariance (2, 2) of the lean that comes on top of the stated one, because neighbouring slices err together.

    The centres less a cubic are summed up in runs of 2, 4 and 8 slices; if runs scatter more than independent slices
    would, the form of the wall keeps its sign over them, and the run length with the largest variance counts.

    Parameters
    ----------
    centres_m : (m, 3) array
        Centres in ascending height, site frame, metres.
    levers : (m,) array
        What the lean changes by if a centre moves by a metre, 1/m.
    stated : (2, 2) array
        Covariance of the lean from independent centres.
    """
    used = np.flatnonzero(levers != 0.0)
    m = len(used)
    if m < LEAST_CENTRES or len(np.unique(centres_m[used, 2])) < LEAST_CENTRES:
        return np.zeros((2, 2))
    pulled = levers[used, None] * _off_cubic(centres_m[used])
    alone = _scatter(pulled, 1)
    if alone == 0.0:
        return np.zeros((2, 2))
    ratio = 1.0
    for length in RUNS:
        runs = m // length
        if runs < LEAST_RUNS:
            break
        here = _scatter(pulled, length) / alone
        ratio = max(ratio, here) if here > 1.0 + SIGNIFICANT / np.sqrt(runs) else ratio
    return np.asarray((ratio - 1.0) * stated)


def _off_cubic(centres_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centres (m, 2) less a least-squares cubic over their height, metres."""
    z = centres_m[:, 2]
    share = 2.0 * (z - z.min()) / np.ptp(z) - 1.0
    basis = np.polynomial.legendre.legvander(share, BENT_ORDER)
    xy = centres_m[:, :2] - centres_m[:, :2].mean(axis=0)
    return np.asarray(xy - basis @ np.linalg.lstsq(basis, xy, rcond=None)[0])


def _scatter(pulled: NDArray[np.float64], length: int) -> float:
    """Sum of squares of what runs of that length pull the lean by, as if all slices were in runs."""
    runs = len(pulled) // length
    sums = pulled[: runs * length].reshape(runs, length, 2).sum(axis=1)
    return float(np.sum(sums**2)) * len(pulled) / (runs * length)
