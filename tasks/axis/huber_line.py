"""Axis estimator ``huber_line``: a straight line with Huber weights."""

from typing import Final

import numpy as np

from tasks.axis.adjustment import median_regression, normal_matrix
from tasks.axis.centres import Centres
from tasks.axis.height_fit import (
    HeightFit,
    Settled,
    badly_spread,
    information_weights,
    reweight,
)
from tasks.axis.line import Axis
from tasks.axis.loss import HUBER
from tasks.axis.model import AxisEstimator
from tasks.axis.observations import Observations
from tasks.axis.procedure import fit_straight
from tasks.geometry.failure import FitFailure


def fit_huber_line(centres: Centres) -> Axis | FitFailure:
    """Fit lines x(z), y(z) with Huber weights; the scale is that of the median length of the residuals.

    There is one solution only, whatever the start, but bad centres keep a part of their pull: with a quarter of them
    bad ``tukey_line`` is better. The covariance follows the influence that the residuals really have; it never falls
    below that of the points alone.

    References
    ----------
    Huber 1981, Robust Statistics, section 7.6 (covariance).
    """
    return fit_straight(centres, _fit_huber)


def _fit_huber(observations: Observations) -> HeightFit | FitFailure:
    try:
        settled = reweight(observations, median_regression(observations), HUBER)
        return settled if isinstance(settled, FitFailure) else _state_influence(observations, settled)
    except np.linalg.LinAlgError:
        return badly_spread(len(observations.basis))


def _state_influence(observations: Observations, settled: Settled) -> HeightFit:
    """State the covariance by the mean square of the influence over the square of its mean slope."""
    m, p = observations.basis.shape
    residuals = observations.residuals(settled.coefficients_m)
    lengths = np.sqrt(observations.squared_lengths(residuals, settled.variance_m2))
    slopes = HUBER.slope(lengths)
    slope = float(slopes.mean())
    few = 1.0 + p / m * float(slopes.var()) / slope**2
    influence = float(np.mean((HUBER.weights(lengths) * lengths) ** 2)) / 2.0 / observations.freedom
    factor = few**2 * influence / slope**2
    if settled.variance_m2 == 0.0:
        factor = max(factor, 1.0 / HUBER.efficiency)
    normal = normal_matrix(observations, np.ones(m), settled.variance_m2)
    covariance = np.asarray(factor * np.linalg.inv(normal), dtype=np.float64)
    return HeightFit(
        coefficients_m=settled.coefficients_m,
        covariance_m2=covariance.reshape(2, p, 2, p),
        robust_weights=settled.weights,
        information_weights=information_weights(observations, settled.weights, settled.variance_m2),
        iterations=settled.iterations,
        model_variance_m2=settled.variance_m2,
        freedom=2 * (m - p) if settled.variance_m2 > 0.0 else 0,
    )


AXIS: Final = AxisEstimator(
    "huber_line", "straight line with Huber weights, scale by the median", fit_huber_line
)
