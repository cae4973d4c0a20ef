"""Fit the axis of a shaft through the centres of its slices (paper 2.3).

An estimator is one file of this folder that defines ``AXIS``; it is found by itself.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.centres import Centres
from tasks.axis.line import MOST_TILT_DEG, Axis, AxisCurve
from tasks.axis.model import AxisEstimator
from tasks.axis.robust_line import LEAST_FOR_BENDING
from tasks.geometry.failure import FitFailure
from tasks.geometry.variants import choose, discover

AXES: Final[dict[str, AxisEstimator]] = discover(__name__, "AXIS", AxisEstimator)
"""The axis estimators that are shipped, by name."""

__all__ = ["AXES", "LEAST_FOR_BENDING", "Axis", "AxisCurve", "AxisEstimator", "fit_axis"]


def fit_axis(
    name: str, centres_m: NDArray[np.float64], covariances_m2: NDArray[np.float64]
) -> Axis | FitFailure:
    """Fit a straight axis through the centres with the estimator of that name.

    Parameters
    ----------
    name : str
        A key of ``AXES``.
    centres_m : (m, 3) array
        Centres of the slices, site frame, metres, in any order.
    covariances_m2 : (m, 2, 2) array
        Covariance of (east, north) of each centre, square metres; the heights are exact.

    Returns
    -------
    Axis or FitFailure
        A failure for fewer than 2 centres, centres at one height, values that are not finite, or an axis that is
        further from the vertical than ``MOST_TILT_DEG``.

    Raises
    ------
    InputError
        If no estimator has that name.
    ShapeError
        If the arrays do not fit together.
    """
    estimator = choose(AXES, name, "axis estimator")
    centres = Centres(centres_m, covariances_m2)
    unfit = centres.unfit()
    if unfit is not None:
        return unfit
    axis = estimator.fit(centres)
    if isinstance(axis, Axis) and axis.tilt_deg > MOST_TILT_DEG:
        return FitFailure(
            f"needs an axis within {MOST_TILT_DEG:g} deg of the vertical, got one at {axis.tilt_deg:.1f} deg"
        )
    return axis
