"""Axis estimator ``robust_line``: weighted lines x(z), y(z) with Tukey weights."""

from typing import Final

import numpy as np

from tasks.axis.bending import bending_m
from tasks.axis.centres import Centres
from tasks.axis.line import (
    Axis,
    direction_of_lean,
    effective_number,
    f_quantile_2,
    line_distances,
    small_sample_factor,
    update_weight_ratio_pct,
)
from tasks.axis.model import AxisEstimator
from tasks.axis.observations import observe
from tasks.axis.robust_polynomial import LEAST_FOR_TUKEY, PolynomialFit, fit_polynomial
from tasks.axis.two_points import fit_two_points
from tasks.geometry.failure import FitFailure

LEAST_FOR_BENDING: Final = LEAST_FOR_TUKEY
"""Centres at different heights below which bending cannot be told from chance."""

BENT_ORDERS: Final = (2, 3)
"""A cubic follows a cantilever within 0.5 % of its bending, a parabola within 3 %."""

BENDING_LEVEL: Final = 0.01
"""Probability with which a straight axis is taken for a bent one."""


def fit_robust_line(centres: Centres) -> Axis | FitFailure:
    """Fit the straight line of an axis, robustly, with the covariances of the centres and a model error.

    Heights are exact: only east and north are measured. A line is fitted first. From 16 different heights on a parabola
    and a cubic are tried too, and where the last term is significant (1 %) the line is the one that fits the curve best,
    uniformly over the height range, whatever the weights of the centres: outliers and sigma are then judged from the
    bent axis, not from a line that does not hold. Residuals and eq. 18 are always those from the line.
    Where the scatter of few centres is all that tells sigma, the covariance is widened for it: ``small_sample_factor``.

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
    if len(np.unique(centres.points_m[:, 2])) >= LEAST_FOR_BENDING:
        for order in BENT_ORDERS:
            bent = fit_polynomial(observe(centres, order))
            if isinstance(bent, PolynomialFit) and _bends(bent, order):
                fit = bent
    return _axis_of(centres, fit)


def _bends(fit: PolynomialFit, order: int) -> bool:
    """Whether the highest term is significant: F test with 2 and 2 (m - order - 1) degrees of freedom."""
    bend = fit.coefficients_m[order]
    statistic = float(bend @ np.linalg.solve(fit.covariance_m2[:, order, :, order], bend)) / 2.0
    freedom = 2 * (int(np.count_nonzero(fit.tukey)) - order - 1)
    return freedom > 0 and statistic > f_quantile_2(1.0 - BENDING_LEVEL, freedom)


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
        lean_covariance=small_sample_factor(fit.freedom) * fit.covariance_m2[:, 1, :, 1] / half_span**2,
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
