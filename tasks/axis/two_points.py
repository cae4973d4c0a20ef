"""Axis estimator ``two_points``: the direct line of schemes E and F."""

from typing import Final

import numpy as np

from tasks.axis.centres import Centres
from tasks.axis.line import Axis, direction_of_lean
from tasks.axis.model import AxisEstimator
from tasks.geometry.failure import FitFailure


def fit_two_points(centres: Centres) -> Axis | FitFailure:
    """Join two centres; the covariance is that of the two centres over the square of their distance in height.

    Nothing is left over to judge the line by: residuals and eq. 18 do not exist.
    """
    if centres.count != 2:
        return FitFailure(f"a direct line needs exactly 2 centres, got {centres.count}")
    low, high = centres.points_m[np.argsort(centres.points_m[:, 2])]
    return Axis(
        point_m=(low + high) / 2,
        direction=direction_of_lean((high - low)[:2] / centres.span_m),
        lean_covariance=centres.covariances_m2.sum(axis=0) / centres.span_m**2,
        weights=np.ones(2),
        residuals_m=None,
        iterations=None,
        n_effective=None,
        mean_deviation_m=None,
        rmse_m=None,
        bending_m=None,
        update_weight_ratio_pct=None,
    )


AXIS: Final = AxisEstimator("two_points", "direct line through two centres", fit_two_points)
