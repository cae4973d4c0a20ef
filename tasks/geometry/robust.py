"""Robust scales and weights.

References
----------
Huber 1981, Robust Statistics; Holland & Welsch 1977, Robust regression using IRLS.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

MAD_TO_SIGMA: Final = 1.4826
"""Makes the median absolute deviation of a normal sample its standard deviation."""

TUKEY_1D: Final = 4.685
"""Cut of Tukey's biweight in sigmas for one-dimensional residuals: efficiency 0.95 at the normal."""

TUKEY_2D: Final = 5.2
"""The same for the length of two-dimensional residuals (docs/estimators.md)."""


def mad_sigma(residuals: NDArray[np.float64]) -> float:
    """Standard deviation from the median absolute value of centred residuals (n,); same unit."""
    return float(MAD_TO_SIGMA * np.median(np.abs(residuals)))


def tukey_weights(residuals: NDArray[np.float64], sigma: float, cut: float = TUKEY_1D) -> NDArray[np.float64]:
    """Tukey's biweight (n,), 1 at zero and 0 beyond ``cut * sigma``; ``sigma`` must be positive."""
    u = np.clip(np.abs(residuals) / (cut * sigma), 0.0, 1.0)
    return np.asarray((1.0 - u * u) ** 2)


def huber_weights(residuals: NDArray[np.float64], sigma: float, cut: float = 1.345) -> NDArray[np.float64]:
    """Huber's weights (n,), 1 within ``cut * sigma`` and falling as 1/|r| beyond it."""
    size = np.maximum(np.abs(residuals), np.finfo(float).tiny)
    return np.asarray(np.minimum(1.0, cut * sigma / size))
