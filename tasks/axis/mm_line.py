"""Axis estimator ``mm_line``: a straight line that holds where a third of the centres is bad."""

from typing import Final

import numpy as np

from tasks.axis.centres import Centres
from tasks.axis.elemental_start import estimate_s
from tasks.axis.height_fit import HeightFit, badly_spread, fit_least_squares, reweight, state
from tasks.axis.line import Axis
from tasks.axis.loss import TUKEY
from tasks.axis.model import AxisEstimator
from tasks.axis.observations import Observations
from tasks.axis.procedure import fit_straight
from tasks.geometry.failure import FitFailure

LEAST_FOR_WEIGHTS: Final = 11
"""As for ``tukey_line``: fewer centres all get the weight 1."""


def fit_mm_line(centres: Centres) -> Axis | FitFailure:
    """Fit lines x(z), y(z) by an MM estimate: start and scale from an S estimate, then Tukey weights with a larger cut.

    The start is the best of the lines through two centres, so that bad centres that agree with each other do not draw
    it; the scale is held while the weights settle. Bending is not looked for.

    References
    ----------
    Yohai 1987, High breakdown-point and high efficiency robust estimates for regression, Ann. Stat. 15.
    """
    few = centres.count < LEAST_FOR_WEIGHTS
    return fit_straight(centres, fit_least_squares if few else _fit_mm)


def _fit_mm(observations: Observations) -> HeightFit | FitFailure:
    try:
        start = estimate_s(observations)
        settled = reweight(observations, start.coefficients_m, TUKEY, start.variance_m2)
        return settled if isinstance(settled, FitFailure) else state(observations, settled, TUKEY)
    except np.linalg.LinAlgError:
        return badly_spread(len(observations.basis))


AXIS: Final = AxisEstimator(
    "mm_line", "straight line that holds with a third of the centres bad (MM estimate)", fit_mm_line
)
