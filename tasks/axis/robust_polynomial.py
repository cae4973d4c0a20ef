"""x(z), y(z) as polynomials through centres of unequal quality, with Tukey weights."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.observations import Observations
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import TUKEY_2D, tukey_weights

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

MEDIAN_REGRESSION_STEPS: Final = 30
"""Reweightings of the start, which need not be exact."""


@dataclass(frozen=True, slots=True)
class _TukeyAtNormal:
    """What Tukey's weights do to normal residuals in the plane.

    ``efficiency`` is that of the location, ``mean_length`` the weighted mean of the squared lengths.
    """

    efficiency: float
    mean_length: float


def _tukey_at_normal(cut: float) -> _TukeyAtNormal:
    """Integrate over the exponential law of half the squared length by Gauss-Legendre quadrature up to the cut."""
    nodes, shares = np.polynomial.legendre.leggauss(60)
    length = (nodes + 1.0) / 2.0 * cut**2
    density = shares * cut**2 / 2.0 * np.exp(-length / 2.0) / 2.0
    ratio = length / cut**2
    weight = (1.0 - ratio) ** 2
    influence = float(density @ (weight**2 * length)) / 2.0
    slope = float(density @ ((1.0 - ratio) * (1.0 - 3.0 * ratio)))
    return _TukeyAtNormal(slope**2 / influence, float(density @ (weight * length)) / float(density @ weight))


TUKEY_AT_NORMAL: Final = _tukey_at_normal(TUKEY_2D)


@dataclass(frozen=True, slots=True, eq=False)
class PolynomialFit:
    """Polynomials of east and north over the height.

    Attributes
    ----------
    coefficients_m : (p, 2) array
        Of the Legendre polynomials, about the origin of the observations, metres.
    covariance_m2 : (2, p, 2, p) array
        Covariance of coefficient (k, component a) with (l, b) at [a, k, b, l], square metres.
    tukey : (m,) array
        Tukey weights.
    information_weights : (m,) array
        Tukey weights times the mean inverse variance of the centre, the largest is 1.
    iterations : int
        Fits that were made.
    freedom : int
        Degrees of freedom that the model error was estimated with; 0 where the points alone explain the scatter.
    """

    coefficients_m: NDArray[np.float64]
    covariance_m2: NDArray[np.float64]
    tukey: NDArray[np.float64]
    information_weights: NDArray[np.float64]
    iterations: int
    freedom: int


def fit_polynomial(observations: Observations) -> PolynomialFit | FitFailure:
    """Fit by weighted least squares with Tukey weights in units of each centre's own standard deviation.

    The covariance of a centre is its own plus a model error (registration, out-of-round, correlation) that is equal for
    all and estimated from the residuals, never below 0: from their median for the weights, from their weighted mean
    square for the final fit and its covariance. So the stated sigma follows the scatter but never falls below what the
    points alone give. Start: least sum of distances.

    References
    ----------
    Huber 1981, Robust Statistics; Paule & Mandel 1982, J. Res. NBS 87 (model error); docs/estimators.md.
    """
    m = len(observations.basis)
    try:
        if m < LEAST_FOR_TUKEY:
            return _finish(observations, _median_regression(observations), np.ones(m), 1)
        return _reweight(observations, _median_regression(observations))
    except np.linalg.LinAlgError:
        return FitFailure(f"needs centres spread over the height, got {m} whose good ones are not")


def _reweight(observations: Observations, start: NDArray[np.float64]) -> PolynomialFit | FitFailure:
    coefficients, variance = start, 0.0
    for iteration in range(1, MOST_ITERATIONS + 1):
        residuals = observations.residuals(coefficients)
        if iteration <= FREE_SCALES:
            variance = observations.median_model_variance(residuals, observations.freedom * MEDIAN_LENGTH)
        lengths = np.sqrt(observations.squared_lengths(residuals, variance))
        tukey = tukey_weights(lengths, 1.0, TUKEY_2D)
        before = coefficients
        coefficients = _solve(observations, tukey, variance)
        typical = np.sqrt(np.median(observations.variances_m2) + variance)
        if np.abs(coefficients - before).max() <= SETTLED * typical:
            return _finish(observations, coefficients, tukey, iteration)
    return FitFailure(f"robust line did not converge in {MOST_ITERATIONS} iterations")


def _finish(
    observations: Observations, coefficients: NDArray[np.float64], tukey: NDArray[np.float64], iterations: int
) -> PolynomialFit:
    """Fit once more with the efficient model error, and state the covariance."""
    at_normal = TUKEY_AT_NORMAL if len(tukey) >= LEAST_FOR_TUKEY else _TukeyAtNormal(1.0, 2.0)
    mean = observations.freedom * at_normal.mean_length
    variance = observations.mean_model_variance(observations.residuals(coefficients), tukey, mean)
    coefficients = _solve(observations, tukey, variance)
    used = (tukey > 0.0).astype(np.float64)
    p = observations.basis.shape[1]
    inverse = np.linalg.inv(_normal_matrix(observations, used, variance))
    covariance = np.asarray(inverse / at_normal.efficiency, dtype=np.float64)
    information = observations.information(variance)
    importance = tukey * (information[:, 0, 0] + information[:, 1, 1])
    freedom = 2 * (int(used.sum()) - p) if variance > 0.0 else 0
    return PolynomialFit(
        coefficients,
        covariance.reshape(2, p, 2, p),
        tukey,
        importance / importance.max(),
        iterations,
        freedom,
    )


def _normal_matrix(
    observations: Observations, weights: NDArray[np.float64], variance: float
) -> NDArray[np.float64]:
    """Normal matrix (2p, 2p), the coefficients of east before those of north."""
    p = observations.basis.shape[1]
    information = observations.information(variance) * weights[:, None, None]
    products = observations.basis[:, :, None] * observations.basis[:, None, :]
    blocks = information.reshape(-1, 4).T @ products.reshape(-1, p * p)
    return np.asarray(blocks.reshape(2, 2, p, p).transpose(0, 2, 1, 3).reshape(2 * p, 2 * p))


def _solve(observations: Observations, weights: NDArray[np.float64], variance: float) -> NDArray[np.float64]:
    """Coefficients (p, 2) of weighted least squares."""
    p = observations.basis.shape[1]
    pulled = np.einsum("mab,mb->ma", observations.information(variance), observations.horizontal_m)
    right = ((pulled * weights[:, None]).T @ observations.basis).reshape(2 * p)
    solution = np.linalg.solve(_normal_matrix(observations, weights, variance), right)
    return np.asarray(solution.reshape(2, p).T, dtype=np.float64)


def _median_regression(observations: Observations) -> NDArray[np.float64]:
    """Coefficients (p, 2) with the least sum of distances, whatever the stated covariances say of the centres."""
    weights = np.ones(len(observations.basis))
    for _ in range(MEDIAN_REGRESSION_STEPS):
        root = np.sqrt(weights)[:, None]
        coefficients = np.asarray(
            np.linalg.lstsq(observations.basis * root, observations.horizontal_m * root, rcond=None)[0],
            dtype=np.float64,
        )
        distances = np.linalg.norm(observations.residuals(coefficients), axis=1)
        floor = 1e-3 * float(np.median(distances))
        if floor == 0.0:
            break
        weights = 1.0 / np.maximum(distances, floor)
        weights = weights / weights.max()
    return coefficients
