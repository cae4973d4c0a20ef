"""Centres of unequal quality, ready for functions of the height."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.centres import Centres
from tasks.axis.forms import Form

SMALLEST_SIGMA: Final = 1e-9
"""Least standard deviation of a centre, as a part of the height range: exact centres must not divide by zero."""


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """East and north of the centres, the functions of a form at their heights, and their covariances.

    Attributes
    ----------
    basis : (m, p) array
        Functions of a form at the heights; the first two are the line over the height range.
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

    def median_model_variance(self, residuals_m: NDArray[np.float64], length: float) -> float:
        """Variance of a model error, equal for all centres, at which that is the median squared length, or 0."""
        squares = self._squares(residuals_m)
        single = np.sort(_model_variances(squares, self.variances_m2, length))
        low, high = float(single[(len(single) - 1) // 2]), float(single[len(single) // 2])

        def excess(variance: float) -> float:
            return median((squares / (self.variances_m2 + variance)).sum(axis=1)) - length

        if high <= 0.0:
            return 0.0
        if low == high:
            return low
        # the median of an even number is the mean of two, so it has its value between theirs
        return _zero_above(excess, max(low, 0.0), high)

    def mean_model_variance(
        self, residuals_m: NDArray[np.float64], weights: NDArray[np.float64], mean: float
    ) -> float:
        """Variance of a model error at which the squared lengths have that weighted mean, or 0."""
        squares = self._squares(residuals_m)

        def excess(variance: float) -> float:
            lengths = (squares / (self.variances_m2 + variance)).sum(axis=1)
            return float(weights @ lengths / weights.sum()) - mean

        return _zero_above(excess, 0.0, 2.0 * float(squares.max()) / mean)

    def s_model_variance(
        self,
        residuals_m: NDArray[np.float64],
        loss: Callable[[NDArray[np.float64]], NDArray[np.float64]],
        mean: float,
    ) -> float:
        """Variance of a model error at which a bounded loss (at most 1) of the squared lengths has that mean, or 0."""
        squares = self._squares(residuals_m)

        def excess(variance: float) -> float:
            return float(np.mean(loss((squares / (self.variances_m2 + variance)).sum(axis=1)))) - mean

        return _zero_above(excess, 0.0, 2.0 * float(squares.max()) / mean)

    def _squares(self, residuals_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray((residuals_m[:, None, :] @ self.turns)[:, 0, :] ** 2)


def observe(centres: Centres, form: Form) -> Observations:
    """Make observations of centres for a form."""
    horizontal = centres.points_m[:, :2]
    origin = horizontal.mean(axis=0)
    variances, turns = np.linalg.eigh(centres.covariances_m2)
    return Observations(
        basis=form.values(centres.place(centres.points_m[:, 2])),
        horizontal_m=horizontal - origin,
        origin_m=origin,
        turns=turns,
        variances_m2=np.maximum(variances, (SMALLEST_SIGMA * centres.span_m) ** 2),
    )


def median(values: NDArray[np.float64]) -> float:
    """Median of values (m,); for short arrays many times faster than that of numpy."""
    ranked = np.sort(values)
    return float(ranked[(len(ranked) - 1) // 2] + ranked[len(ranked) // 2]) / 2.0


def _model_variances(
    squares: NDArray[np.float64], variances_m2: NDArray[np.float64], length: float
) -> NDArray[np.float64]:
    """Variance (m,) at which each squared residual (m, 2) has that squared length: larger root of a quadratic."""
    half = (variances_m2.sum(axis=1) - squares.sum(axis=1) / length) / 2.0
    last = variances_m2.prod(axis=1) - (squares * variances_m2[:, ::-1]).sum(axis=1) / length
    return np.asarray(np.sqrt(np.maximum(half**2 - last, 0.0)) - half)


def _zero_above(excess: Callable[[float], float], low: float, high: float) -> float:
    """Root of a falling function between ``low`` and ``high``, or ``low`` where it is not above zero there."""
    if excess(low) <= 0.0:
        return low
    if excess(high) >= 0.0:
        return high
    from scipy.optimize import brentq  # noqa: PLC0415 (slow to import, and every command reads settings)

    return float(brentq(excess, low, high, xtol=1e-12 * high, rtol=1e-10))
