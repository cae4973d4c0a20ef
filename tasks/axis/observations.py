"""Centres of unequal quality, ready for polynomials of the height."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from tasks.axis.bending import height_basis
from tasks.axis.centres import Centres

SMALLEST_SIGMA: Final = 1e-9
"""Least standard deviation of a centre, as a part of the height range: exact centres must not divide by zero."""


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """East and north of the centres, the polynomials at their heights, and their covariances.

    Attributes
    ----------
    basis : (m, p) array
        Legendre polynomials of order 0 to p - 1 over the height range.
    horizontal_m : (m, 2) array
        East and north of the centres about ``origin_m``, metres.
    origin_m : (2,) array
        Their mean, metres: taken off so that large coordinates cost no digits.
    turns : (m, 2, 2) array
        Principal axes of each covariance, as columns.
    variances_m2 : (m, 2) array
        Variances along them, square metres.
    """

    basis: NDArray[np.float64]
    horizontal_m: NDArray[np.float64]
    origin_m: NDArray[np.float64]
    turns: NDArray[np.float64]
    variances_m2: NDArray[np.float64]

    @property
    def freedom(self) -> float:
        """Redundancy of the average centre: (m - p) / m."""
        m, p = self.basis.shape
        return float(m - p) / float(m)

    def residuals(self, coefficients_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residuals (m, 2) of coefficients (p, 2), metres."""
        return np.asarray(self.horizontal_m - self.basis @ coefficients_m)

    def information(self, model_variance_m2: float) -> NDArray[np.float64]:
        """Inverse covariances (m, 2, 2) of the centres with a model error of that variance added."""
        scaled = self.turns / (self.variances_m2 + model_variance_m2)[:, None, :]
        return np.asarray(scaled @ self.turns.transpose(0, 2, 1))

    def squared_lengths(
        self, residuals_m: NDArray[np.float64], model_variance_m2: float
    ) -> NDArray[np.float64]:
        """Squared residuals (m,) in units of their standard deviation: chi-square with 2 degrees of freedom."""
        return np.asarray((self._squares(residuals_m) / (self.variances_m2 + model_variance_m2)).sum(axis=1))

    def median_model_variance(self, residuals_m: NDArray[np.float64], median: float) -> float:
        """Variance of a model error, equal for all centres, at which the squared lengths have that median, or 0."""
        squares = self._squares(residuals_m)

        def excess(variance: float) -> float:
            return float(np.median((squares / (self.variances_m2 + variance)).sum(axis=1))) - median

        return _zero_above(excess, 2.0 * float(squares.max()) / median)

    def mean_model_variance(
        self, residuals_m: NDArray[np.float64], weights: NDArray[np.float64], mean: float
    ) -> float:
        """Variance of a model error at which the squared lengths have that weighted mean, or 0."""
        squares = self._squares(residuals_m)

        def excess(variance: float) -> float:
            lengths = (squares / (self.variances_m2 + variance)).sum(axis=1)
            return float(weights @ lengths / weights.sum()) - mean

        return _zero_above(excess, 2.0 * float(squares.max()) / mean)

    def _squares(self, residuals_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.einsum("mab,ma->mb", self.turns, residuals_m) ** 2)


def observe(centres: Centres, order: int) -> Observations:
    """Make observations of centres for polynomials up to an order."""
    horizontal = centres.points_m[:, :2]
    origin = horizontal.mean(axis=0)
    variances, turns = np.linalg.eigh(centres.covariances_m2)
    return Observations(
        basis=height_basis(centres.points_m[:, 2], centres.lowest_m, centres.span_m, order),
        horizontal_m=horizontal - origin,
        origin_m=origin,
        turns=turns,
        variances_m2=np.maximum(variances, (SMALLEST_SIGMA * centres.span_m) ** 2),
    )


def _zero_above(excess: Callable[[float], float], high: float) -> float:
    """Root of a falling function between 0 and ``high``, or 0 where it is not above zero there."""
    if excess(0.0) <= 0.0:
        return 0.0
    return float(brentq(excess, 0.0, high, xtol=1e-12 * high, rtol=1e-10))
