"""East and north as functions of the height, through centres of unequal quality."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.adjustment import median_regression, normal_matrix, solve_weighted
from tasks.axis.loss import NO_LOSS, TUKEY, Loss
from tasks.axis.observations import Observations, median
from tasks.geometry.failure import FitFailure

MEDIAN_LENGTH: Final = float(2.0 * np.log(2.0))
"""Median of the squared length of a standard normal vector in the plane."""

LEAST_FOR_TUKEY: Final = 16
"""Fewer centres cannot tell an outlier from bending or from chance: weights stay 1. With 6 centres of equal quality
Tukey's weights made the chi-square of the lean 4.7 on average instead of 2, without them it is 1.95."""

MOST_ITERATIONS: Final = 300
"""Fits before it counts as not converged; good data need about 15."""

FREE_SCALES: Final = 10
"""After as many fits the model error is held: a median may swing between two centres for ever."""

SETTLED: Final = 1e-9
"""A change of the coefficients below this part of the typical sigma ends the iteration."""


@dataclass(frozen=True, slots=True, eq=False)
class HeightFit:
    """East and north as sums of functions of the height.

    Attributes
    ----------
    coefficients_m : (p, 2) array
        Of the functions, about the origin of the observations, metres.
    covariance_m2 : (2, p, 2, p) array
        Covariance of coefficient (k, component a) with (l, b) at [a, k, b, l], square metres.
    robust_weights : (m,) array
        Weights by the residuals alone.
    information_weights : (m,) array
        Robust weights times the mean inverse variance of the centre, the largest is 1.
    iterations : int
        Fits that were made.
    model_variance_m2 : float
        Variance of the model error, square metres.
    freedom : int
        Degrees of freedom that the model error was estimated with; 0 where the points alone explain the scatter.
    """

    coefficients_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64]
    robust_weights: NDArray[np.float64]
    information_weights: NDArray[np.float64]
    iterations: int
    model_variance_m2: float
    freedom: int

    @property
    def redundancy(self) -> int:
        """Observed coordinates with a weight beyond the number of coefficients."""
        return 2 * (int(np.count_nonzero(self.robust_weights)) - len(self.coefficients_m))


@dataclass(frozen=True, slots=True, eq=False)
class Settled:
    """Where an iteration ended: coefficients (p, 2), metres, weights (m,), model error, and the fits it took."""

    coefficients_m: NDArray[np.float64]
    weights: NDArray[np.float64]
    variance_m2: float
    iterations: int


def fit_robustly(observations: Observations) -> HeightFit | FitFailure:
    """Fit by weighted least squares with Tukey weights in units of each centre's own standard deviation.

    The covariance of a centre is its own plus a model error (registration, out-of-round, correlation) that is equal for
    all and estimated from the residuals, never below 0: from their median for the weights, from their weighted mean
    square for the final fit and its covariance. So the stated sigma follows the scatter but never falls below what the
    points alone give. Start: least sum of distances. Fewer than ``LEAST_FOR_TUKEY`` centres all get the weight 1.

    References
    ----------
    Huber 1981, Robust Statistics; Paule & Mandel 1982, J. Res. NBS 87 (model error); docs/estimators.md.
    """
    m = len(observations.basis)
    try:
        start = median_regression(observations)
        if m < LEAST_FOR_TUKEY:
            return state(observations, Settled(start, np.ones(m), 0.0, 1), NO_LOSS)
        settled = reweight(observations, start, TUKEY)
        return settled if isinstance(settled, FitFailure) else state(observations, settled, TUKEY)
    except np.linalg.LinAlgError:
        return badly_spread(m)


def fit_least_squares(observations: Observations) -> HeightFit | FitFailure:
    """Fit by weighted least squares, every robust weight 1, with the model error at which the residuals fit.

    References
    ----------
    Paule & Mandel 1982, J. Res. NBS 87.
    """
    ones = np.ones(len(observations.basis))
    variance = 0.0
    try:
        coefficients = solve_weighted(observations, ones, variance)
        for iteration in range(2, MOST_ITERATIONS + 1):
            before = coefficients
            residuals = observations.residuals(coefficients)
            variance = observations.mean_model_variance(residuals, ones, 2.0 * observations.freedom)
            coefficients = solve_weighted(observations, ones, variance)
            if has_settled(observations, before, coefficients, variance):
                return state(observations, Settled(coefficients, ones, variance, iteration), NO_LOSS)
    except np.linalg.LinAlgError:
        return badly_spread(len(ones))
    return FitFailure(f"model error did not settle in {MOST_ITERATIONS} fits")


def reweight(
    observations: Observations,
    start_m: NDArray[np.float64],
    loss: Loss,
    held_variance_m2: float | None = None,
) -> Settled | FitFailure:
    """Reweight from a start until the coefficients settle; the model error follows the median unless one is given."""
    coefficients = start_m
    variance = 0.0 if held_variance_m2 is None else held_variance_m2
    for iteration in range(1, MOST_ITERATIONS + 1):
        residuals = observations.residuals(coefficients)
        if held_variance_m2 is None and iteration <= FREE_SCALES:
            variance = observations.median_model_variance(residuals, observations.freedom * MEDIAN_LENGTH)
        weights = loss.weights(np.sqrt(observations.squared_lengths(residuals, variance)))
        before = coefficients
        coefficients = solve_weighted(observations, weights, variance)
        if has_settled(observations, before, coefficients, variance):
            return Settled(coefficients, weights, variance, iteration)
    return FitFailure(f"robust line did not converge in {MOST_ITERATIONS} iterations")


def has_settled(
    observations: Observations,
    before_m: NDArray[np.float64],
    after_m: NDArray[np.float64],
    variance_m2: float,
) -> bool:
    """Whether two sets of coefficients are the same, measured by the typical sigma of a centre."""
    typical = float(np.sqrt(median(observations.variances_m2.ravel()) + variance_m2))
    return float(np.abs(after_m - before_m).max()) <= SETTLED * typical


def state(observations: Observations, settled: Settled, loss: Loss) -> HeightFit:
    """Fit once more with the efficient model error, and state the covariance."""
    weights = settled.weights
    mean = observations.freedom * loss.mean_length
    residuals = observations.residuals(settled.coefficients_m)
    variance = observations.mean_model_variance(residuals, weights, mean)
    coefficients = solve_weighted(observations, weights, variance)
    used = (weights > 0.0).astype(np.float64)
    p = observations.basis.shape[1]
    covariance = np.linalg.inv(normal_matrix(observations, used, variance)) / loss.efficiency
    return HeightFit(
        coefficients_m=coefficients,
        covariance_m2=np.asarray(covariance, dtype=np.float64).reshape(2, p, 2, p),
        robust_weights=weights,
        information_weights=information_weights(observations, weights, variance),
        iterations=settled.iterations,
        model_variance_m2=variance,
        freedom=2 * (int(used.sum()) - p) if variance > 0.0 else 0,
    )


def information_weights(
    observations: Observations, weights: NDArray[np.float64], variance_m2: float
) -> NDArray[np.float64]:
    """Weights (m,) times the mean inverse variance of each centre, the largest is 1."""
    importance = weights * (1.0 / (observations.variances_m2 + variance_m2)).sum(axis=1)
    return np.asarray(importance / importance.max())


def badly_spread(m: int) -> FitFailure:
    """Say that the centres that count do not determine the form."""
    return FitFailure(f"needs centres spread over the height, got {m} whose good ones are not")
