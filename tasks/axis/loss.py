"""Losses for residuals in the plane, and what they do to normal ones."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import TUKEY_2D, huber_weights, tukey_weights


@dataclass(frozen=True, slots=True)
class Loss:
    """A weight function of the length of a residual in units of its standard deviation.

    Attributes
    ----------
    weights : function
        From lengths (m,) to weights (m,), 1 at zero.
    slope : function
        From lengths (m,) to half the divergence (m,) of the influence, 1 at zero.
    efficiency : float
        Of the location, for normal residuals in the plane.
    mean_length : float
        Weighted mean of the squared length of normal residuals in the plane; 2 without weights.
    """

    weights: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    slope: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    efficiency: float
    mean_length: float


def tukey(cut: float) -> Loss:
    """Tukey's biweight, 0 beyond ``cut``."""

    def weights(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
        return tukey_weights(lengths, 1.0, cut)

    def slope(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
        ratio = np.minimum(lengths / cut, 1.0) ** 2
        return np.asarray((1.0 - ratio) * (1.0 - 3.0 * ratio))

    return _at_normal(weights, slope, cut)


def huber(cut: float) -> Loss:
    """Huber's weights: 1 up to ``cut``, then falling as the inverse length."""

    def weights(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
        return huber_weights(lengths, 1.0, cut)

    def slope(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(lengths <= cut, 1.0, weights(lengths) / 2.0)

    return _at_normal(weights, slope, cut)


def bounded_loss(squared_lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Tukey's loss (m,) with the cut ``HALF_BREAKDOWN``: 0 at zero, 1 beyond the cut."""
    return np.asarray(1.0 - (1.0 - np.minimum(squared_lengths / HALF_BREAKDOWN**2, 1.0)) ** 3)


def _at_normal(
    weights: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    slope: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    cut: float,
) -> Loss:
    """Integrate over the law of the length by Gauss-Legendre quadrature, below the cut and beyond it."""
    nodes, shares = np.polynomial.legendre.leggauss(80)
    edges = np.array([0.0, cut, cut + 12.0])
    halves = np.diff(edges) / 2.0
    lengths = (edges[:-1, None] + halves[:, None] * (nodes + 1.0)).ravel()
    density = (halves[:, None] * shares).ravel() * lengths * np.exp(-(lengths**2) / 2.0)
    weight = weights(lengths)
    influence = float(density @ (weight * lengths) ** 2) / 2.0
    efficiency = float(density @ slope(lengths)) ** 2 / influence
    mean_length = float(density @ (weight * lengths**2)) / float(density @ weight)
    return Loss(weights, slope, efficiency, mean_length)


HALF_BREAKDOWN: Final = 2.6608033929474355
"""Cut of Tukey's loss at which its mean for normal residuals in the plane is half of its largest value."""

NO_LOSS: Final = Loss(np.ones_like, np.ones_like, 1.0, 2.0)
"""Least squares."""

TUKEY: Final = tukey(TUKEY_2D)
"""Efficiency 0.95 at the normal."""

TUKEY_S: Final = tukey(HALF_BREAKDOWN)
"""Weights of an S estimate: efficiency 0.58 at the normal, holds with nearly half of the centres bad."""

HUBER: Final = huber(1.5)
"""Efficiency 0.95 at the normal."""
