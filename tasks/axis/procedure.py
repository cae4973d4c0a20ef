"""What the estimators of an axis have in common: two centres, one fit or the choice of a form, and the axis that follows."""

from collections.abc import Callable

from tasks.axis.centres import Centres
from tasks.axis.curve import curve_of
from tasks.axis.form_choice import Chosen
from tasks.axis.forms import STRAIGHT
from tasks.axis.height_fit import HeightFit, fit_robustly
from tasks.axis.line import Axis
from tasks.axis.observations import Observations, observe
from tasks.axis.outcome import axis_of, warning_of
from tasks.axis.two_points import fit_two_points
from tasks.geometry.failure import FitFailure


def fit_straight(
    centres: Centres, fit: Callable[[Observations], HeightFit | FitFailure]
) -> Axis | FitFailure:
    """Fit a straight line in one way; two centres are joined."""
    if centres.count == 2:
        return fit_two_points(centres)
    fitted = fit(observe(centres, STRAIGHT))
    if isinstance(fitted, FitFailure):
        return fitted
    return axis_of(centres, fitted, warning=warning_of(centres, STRAIGHT, fitted))


def fit_chosen_form(centres: Centres, choose: Callable[[Centres, HeightFit], Chosen]) -> Axis | FitFailure:
    """Fit a robust line, let a form be chosen beside it, and tell the axis with its curve; two centres are joined."""
    if centres.count == 2:
        return fit_two_points(centres)
    straight = fit_robustly(observe(centres, STRAIGHT))
    if isinstance(straight, FitFailure):
        return straight
    chosen = choose(centres, straight)
    curve = curve_of(centres, chosen.form, chosen.fit, chosen.reason)
    return axis_of(centres, chosen.fit, curve, warning_of(centres, chosen.form, chosen.fit))
