"""Axis estimator ``bent_axis``: line, parabola, cubic or spline, whichever the centres ask for."""

from typing import Final

from tasks.axis.centres import Centres
from tasks.axis.form_choice import Chosen, carries, examine
from tasks.axis.forms import STRAIGHT, ClampedSpline, Form, Polynomial
from tasks.axis.height_fit import HeightFit, fit_robustly
from tasks.axis.line import Axis
from tasks.axis.model import AxisEstimator
from tasks.axis.observations import observe
from tasks.axis.procedure import fit_chosen_form
from tasks.geometry.failure import FitFailure

LEAST_FOR_SPLINES: Final = 40
"""Different heights from which a spline is tried."""

BENT: Final[tuple[Form, ...]] = (Polynomial(2), Polynomial(3))

SPLINES: Final[tuple[Form, ...]] = (ClampedSpline(1), ClampedSpline(3))
"""The knots of the first are among those of the second, and both hold every cubic: each form contains the one before."""


def fit_bent_axis(centres: Centres) -> Axis | FitFailure:
    """Fit the form that the centres ask for, robustly, and the straight line that fits it best over the height.

    From the line upwards a form is taken where what it adds to the last one taken is significant (F test, 1 %, with the
    covariance of the fit) and lowers the Bayesian information criterion: parabola, cubic, from 40 heights on clamped
    cubic splines of 2 and 4 spans. The lean is that of the line, uniformly over the height range whatever the density of
    the centres; base tangent, chord and curve stand beside it.

    References
    ----------
    docs/estimators.md.
    """
    return fit_chosen_form(centres, _climb)


def _climb(centres: Centres, straight: HeightFit) -> Chosen:
    """Go through the forms from few functions to many."""
    heights = centres.heights
    chosen = Chosen(STRAIGHT, straight, "")
    reasons = []
    for form in BENT + (SPLINES if heights >= LEAST_FOR_SPLINES else ()):
        if not carries(centres, form):
            reasons.append(f"{heights} heights carry no {form.model}")
            break
        fit = fit_robustly(observe(centres, form))
        if isinstance(fit, FitFailure):
            reasons.append(f"{form.model} fails: {fit.reason}")
            continue
        test = examine(fit, chosen.form.count)
        if test is None:
            reasons.append(f"{form.model}: nothing left over to test it")
            continue
        reasons.append(f"{form.model} over {chosen.form.model} {test.text}, BIC {test.bic_change:+.1f}")
        if test.significant and test.bic_change < 0.0:
            chosen = Chosen(form, fit, "")
    return Chosen(chosen.form, chosen.fit, "; ".join(reasons))


AXIS: Final = AxisEstimator(
    "bent_axis",
    "line, parabola, cubic or spline by F test and BIC, and the line that fits it best",
    fit_bent_axis,
)
