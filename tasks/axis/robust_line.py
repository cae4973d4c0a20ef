"""Axis estimator ``robust_line``: weighted lines x(z), y(z) with Tukey weights."""

from typing import Final

from tasks.axis.centres import Centres
from tasks.axis.form_choice import Chosen, examine
from tasks.axis.forms import STRAIGHT, Polynomial
from tasks.axis.height_fit import LEAST_FOR_TUKEY, HeightFit, fit_robustly
from tasks.axis.line import Axis
from tasks.axis.model import AxisEstimator
from tasks.axis.observations import observe
from tasks.axis.procedure import fit_chosen_form
from tasks.geometry.failure import FitFailure

LEAST_FOR_BENDING: Final = LEAST_FOR_TUKEY
"""Centres at different heights below which bending cannot be told from chance."""

BENT: Final = (Polynomial(2), Polynomial(3))
"""A cubic follows a cantilever within 0.5 % of its bending, a parabola within 3 %."""


def fit_robust_line(centres: Centres) -> Axis | FitFailure:
    """Fit the straight line of an axis, robustly, with the covariances of the centres and a model error.

    Heights are exact: only east and north are measured. A line is fitted first. From 16 different heights on a parabola
    and a cubic are tried too, and where the last term is significant (1 %) the line is the one that fits the curve best,
    uniformly over the height range, whatever the weights of the centres: outliers and sigma are then judged from the
    bent axis, not from a line that does not hold. Residuals and eq. 18 are always those from the line; the curve, its
    base tangent and its chord are stated beside it.
    Where the scatter of few centres is all that tells sigma, the covariance is widened for it: ``small_sample_factor``.

    With two centres there is no redundancy: the covariance is that of the two centres.

    References
    ----------
    docs/estimators.md.
    """
    return fit_chosen_form(centres, _try_bending)


def _try_bending(centres: Centres, straight: HeightFit) -> Chosen:
    """Take the highest order whose last term is significant."""
    if centres.heights < LEAST_FOR_BENDING:
        reason = f"bending is tried from {LEAST_FOR_BENDING} heights on, got {centres.heights}"
        return Chosen(STRAIGHT, straight, reason)
    form, fit, reasons = STRAIGHT, straight, []
    for candidate in BENT:
        bent = fit_robustly(observe(centres, candidate))
        if isinstance(bent, FitFailure):
            reasons.append(f"{candidate.model} fails: {bent.reason}")
            continue
        test = examine(bent, candidate.order)
        if test is None:
            reasons.append(f"{candidate.model}: nothing left over to test it")
            continue
        reasons.append(f"{candidate.model} {test.text}")
        if test.significant:
            form, fit = candidate, bent
    return Chosen(form, fit, "; ".join(reasons))


AXIS: Final = AxisEstimator(
    "robust_line", "weighted line with Tukey weights and an estimated model error", fit_robust_line
)
