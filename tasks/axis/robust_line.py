"""Axis estimator ``robust_line``: weighted lines x(z), y(z) with Tukey weights."""

from typing import Final

import numpy as np

from tasks.axis.bending import bending_m
from tasks.axis.centres import Centres
from tasks.axis.line import (
    Axis,
    direction_of_lean,
    effective_number,
    line_distances,
    update_weight_ratio_pct,
)
from tasks.axis.model import AxisEstimator
from tasks.axis.observations import observe
from tasks.axis.robust_polynomial import PolynomialFit, fit_polynomial
from tasks.axis.two_points import fit_two_points
from tasks.geometry.failure import FitFailure

LEAST_FOR_PARABOLA: Final = 16
"""Centres at different heights below which bending cannot be told from outliers."""

BENDING_LEVEL: Final = 0.01
"""Probability with which a straight axis is taken for a bent one."""


def fit_robust_line(centres: Centres) -> Axis | FitFailure:
    """Fit the straight line of an axis, robustly, with the covariances of the centres and a model error.

    Heights are exact: only east and north are measured. A line is fitted first. From 16 different heights on a parabola
    is tried too, and where its bending is significant (1 %) the line is the one that fits the parabola best, uniformly
    over the height range, whatever the weights of the centres: outliers and sigma are then judged from the bent axis,
    not from a line that does not hold. Residuals and eq. 18 are always those from the line.

    With two centres there is no redundancy: the covariance is that of the two centres.

    References
    ----------
    docs/estimators.md.
    """
    if centres.count == 2:
        return fit_two_points(centres)
    fit = fit_polynomial(observe(centres, 1))
    if isinstance(fit, FitFailure):
        return fit
    if len(np.unique(centres.points_m[:, 2])) >= LEAST_FOR_PARABOLA:
        bent = fit_polynomial(observe(centres, 2))
        if isinstance(bent, PolynomialFit) and _bends(bent):
            fit = bent
    return _axis_of(centres, fit)


def _bends(fit: PolynomialFit) -> bool:
    """Whether the second-order term is significant: F test with 2 and 2 (m - 3) degrees of freedom."""
    bend = fit.coefficients_m[2]
    statistic = float(bend @ np.linalg.solve(fit.covariance_m2[:, 2, :, 2], bend)) / 2.0
    freedom = 2.0 * (int(np.count_nonzero(fit.tukey)) - 3)
    if freedom <= 0.0:
        return False
    # quantile of F with 2 numerator degrees of freedom, in closed form
    return bool(statistic > freedom / 2.0 * (BENDING_LEVEL ** (-2.0 / freedom) - 1.0))


def _axis_of(centres: Centres, fit: PolynomialFit) -> Axis:
    """Take the line of a fit: its first two coefficients, the parabola being orthogonal to them."""
    half_span = centres.span_m / 2
    middle = centres.points_m[:, :2].mean(axis=0) + fit.coefficients_m[0]
    point = np.array([middle[0], middle[1], centres.lowest_m + half_span])
    direction = direction_of_lean(fit.coefficients_m[1] / half_span)
    residuals = line_distances(centres.points_m, point, direction)
    weights = fit.information_weights
    return Axis(
        point_m=point,
        direction=direction,
        lean_covariance=fit.covariance_m2[:, 1, :, 1] / half_span**2,
        weights=weights,
        residuals_m=residuals,
        iterations=fit.iterations,
        n_effective=effective_number(weights),
        mean_deviation_m=float(residuals.mean()),
        rmse_m=float(np.sqrt(np.mean(residuals**2))),
        bending_m=bending_m(centres, fit.tukey),
        update_weight_ratio_pct=update_weight_ratio_pct(weights),
    )


AXIS: Final = AxisEstimator(
    "robust_line", "weighted line with Tukey weights and an estimated model error", fit_robust_line
)
