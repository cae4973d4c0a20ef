"""Axis estimator ``spline_axis``: a clamped cubic B-spline and the line that fits it best."""

from typing import Final

import numpy as np

from tasks.axis.adjustment import solve_weighted
from tasks.axis.centres import Centres
from tasks.axis.curve import curve_of
from tasks.axis.form_choice import Chosen, carries
from tasks.axis.forms import STRAIGHT, ClampedSpline, Polynomial
from tasks.axis.height_fit import HeightFit, fit_robustly
from tasks.axis.line import Axis
from tasks.axis.model import AxisEstimator
from tasks.axis.observations import Observations, observe
from tasks.axis.outcome import axis_of, warning_of
from tasks.axis.two_points import fit_two_points
from tasks.geometry.failure import FitFailure

MOST_KNOTS: Final = 7
"""Of a shaft of 100 m eight spans of 12 m: what bends within less is no axis but a fault of the surface."""

HEIGHTS_A_FUNCTION: Final = 5
"""Different heights that every function must have before there are knots: with fewer the weights follow the noise."""

LEAST_LEAD: Final = 6.0
"""By how much knots must lower the criterion below that of the cubic: strong evidence. Knots that only follow the noise
treble the scatter of the base tangent."""


def fit_spline_axis(centres: Centres) -> Axis | FitFailure:
    """Fit a clamped cubic B-spline, robustly, and the straight line that fits it best over the height.

    Of 0 to 7 equally spaced knots those with the smallest Bayesian information criterion are taken, if it lies clearly
    below that of the cubic (no knots); all are judged with the Tukey weights and the model error of the most knots that
    the heights carry. Fewer than 7 heights carry no cubic: the
    polynomial that they do carry is fitted, and the reason of the curve says so. The sigma takes the knots as given.

    References
    ----------
    de Boor 2001, A Practical Guide to Splines; Schwarz 1978, Ann. Stat. 6; Kass & Raftery 1995, J. Am. Stat. Assoc. 90.
    """
    if centres.count == 2:
        return fit_two_points(centres)
    affordable = max(min(MOST_KNOTS, centres.heights // HEIGHTS_A_FUNCTION - ClampedSpline(0).count), 0)
    knots = [k for k in range(affordable + 1) if carries(centres, ClampedSpline(k))]
    chosen = _choose_knots(centres, knots) if knots else _lower_order(centres)
    if isinstance(chosen, FitFailure):
        return chosen
    curve = curve_of(centres, chosen.form, chosen.fit, chosen.reason)
    return axis_of(centres, chosen.fit, curve, warning_of(centres, chosen.form, chosen.fit))


def _lower_order(centres: Centres) -> Chosen | FitFailure:
    """Fit the polynomial that few heights carry."""
    form = Polynomial(2) if carries(centres, Polynomial(2)) else STRAIGHT
    fit = fit_robustly(observe(centres, form))
    if isinstance(fit, FitFailure):
        return fit
    return Chosen(form, fit, f"{centres.heights} heights carry no spline")


def _choose_knots(centres: Centres, knots: list[int]) -> Chosen | FitFailure:
    """Take the knots with the least criterion; those whose fit fails judge nothing and are not taken."""
    failed: list[str] = []
    for most in reversed(knots):
        judge = fit_robustly(observe(centres, ClampedSpline(most)))
        if isinstance(judge, HeightFit):
            return _choose_up_to(centres, knots[: knots.index(most) + 1], judge, failed)
        failed.append(f"{most} knots: {judge.reason}")
    return FitFailure("; ".join(failed))


def _choose_up_to(
    centres: Centres, knots: list[int], judge: HeightFit, failed: list[str]
) -> Chosen | FitFailure:
    criteria = [_criterion(observe(centres, ClampedSpline(k)), judge) for k in knots]
    best = int(np.argmin(criteria))
    form = ClampedSpline(knots[best if criteria[0] - criteria[best] >= LEAST_LEAD else 0])
    fit = fit_robustly(observe(centres, form))
    if isinstance(fit, FitFailure):
        return fit
    tried = [f"{k} knots: BIC {c - criteria[0]:+.1f}" for k, c in zip(knots[1:], criteria[1:], strict=True)]
    few = [] if tried else [f"{centres.heights} heights carry no inner knots"]
    return Chosen(form, fit, "; ".join([*few, *tried, *failed]))


def _criterion(observations: Observations, judge: HeightFit) -> float:
    """Bayesian information criterion of a form with the weights and the model error of another fit.

    Infinite where the centres that count do not determine the form.
    """
    try:
        coefficients = solve_weighted(observations, judge.robust_weights, judge.model_variance_m2)
    except np.linalg.LinAlgError:
        return np.inf
    lengths = observations.squared_lengths(observations.residuals(coefficients), judge.model_variance_m2)
    observed = 2 * int(np.count_nonzero(judge.robust_weights))
    misfit = max(float(judge.robust_weights @ lengths), float(np.finfo(np.float64).tiny))
    return float(observed * np.log(misfit) + coefficients.size * np.log(observed))


AXIS: Final = AxisEstimator(
    "spline_axis", "clamped cubic B-spline, knots by BIC, and the line that fits it best", fit_spline_axis
)
