"""Where the axis is at the last epoch and how fast it goes, as an average over what is not known for certain."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

TREND_P: Final = 0.01
"""A rate or a change point is significant below this probability, as a change between two epochs is."""


@dataclass(frozen=True, slots=True)
class PlaneVector:
    """A vector east and north (2,) with its covariance (2, 2)."""

    value: NDArray[np.float64]
    covariance: NDArray[np.float64]

    @property
    def size(self) -> float:
        """Its length."""
        return math.hypot(*self.value)

    @property
    def sigma(self) -> float:
        """Standard deviation of the length: along the vector, in the worst direction where it is zero."""
        if self.size == 0.0:
            return math.sqrt(float(np.linalg.eigvalsh(self.covariance)[-1]))
        along = self.value / self.size
        return math.sqrt(float(along @ self.covariance @ along))


@dataclass(frozen=True, slots=True)
class Outlook:
    """State and rate as weighted normal distributions, one for each value of what is not known (random walk, onset).

    Parameters
    ----------
    weights : (g,) array
        They add up to 1.
    states : (g, 4) array
        Movement at the last epoch, metres, and rate, metres a year; east and north each.
    covariances : (g, 4, 4) array
        Without what is common to all epochs.
    walks : (g,) array
        Sigma of the random walk that goes on after the last epoch, metres per square root of a year.
    common : (2, 2) array
        Covariance of the movement that all epochs share.
    """

    weights: NDArray[np.float64]
    states: NDArray[np.float64]
    covariances: NDArray[np.float64]
    walks: NDArray[np.float64]
    common: NDArray[np.float64]

    @property
    def rate(self) -> PlaneVector:
        """Mean rate and its covariance over all nodes, metres a year."""
        return mean_of(self.weights, self.states[:, 2:], self.covariances[:, 2:, 2:])

    @property
    def movement(self) -> PlaneVector:
        """Mean movement at the last epoch and its covariance, with what is common, metres."""
        found = mean_of(self.weights, self.states[:, :2], self.covariances[:, :2, :2])
        return PlaneVector(found.value, found.covariance + self.common)

    @property
    def rate_p_value(self) -> float:
        """Probability of such a rate or a larger one if there is none: the mean of that of every node."""
        return mean_p_value(self.weights, self.states[:, 2:], self.covariances[:, 2:, 2:])


def mean_of(
    weights: NDArray[np.float64], values: NDArray[np.float64], covariances: NDArray[np.float64]
) -> PlaneVector:
    """Mean and covariance of weighted normal distributions: values (g, 2), covariances (g, 2, 2)."""
    mean = weights @ values
    off = values - mean
    spread = np.einsum("g,gi,gj->ij", weights, off, off)
    return PlaneVector(mean, np.einsum("g,gij->ij", weights, covariances) + spread)


def mean_p_value(
    weights: NDArray[np.float64], values: NDArray[np.float64], covariances: NDArray[np.float64]
) -> float:
    """Chi-square test of a vector being zero with 2 degrees of freedom, averaged over the nodes."""
    chi2 = np.einsum("gi,gi->g", values, np.linalg.solve(covariances, values[..., None])[..., 0])
    return float(weights @ np.exp(-chi2 / 2.0))
