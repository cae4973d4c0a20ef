"""Axis estimator ``weighted_line``: weighted least squares, no robustness."""

from typing import Final

from tasks.axis.centres import Centres
from tasks.axis.height_fit import fit_least_squares
from tasks.axis.line import Axis
from tasks.axis.model import AxisEstimator
from tasks.axis.procedure import fit_straight
from tasks.geometry.failure import FitFailure


def fit_weighted_line(centres: Centres) -> Axis | FitFailure:
    """Fit lines x(z), y(z) by weighted least squares with the full covariances of the centres and a model error.

    Best where the centres are good, ruined by a bad one: outliers belong to the points of a slice, or to ``tukey_line``.
    The model error is equal for all centres and such that the residuals fit their covariances, never below 0. Of a bent
    axis it is uniform over the height only if the centres are.
    """
    return fit_straight(centres, fit_least_squares)


AXIS: Final = AxisEstimator(
    "weighted_line", "weighted least squares with an estimated model error", fit_weighted_line
)
