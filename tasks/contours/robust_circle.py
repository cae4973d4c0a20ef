"""Contour model ``robust_circle``: orthogonal distances with Tukey's biweight."""

from typing import Final

from tasks.contours.circle_fit import contour_of
from tasks.contours.circle_start import resistant_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import straighten
from tasks.contours.tukey_circle import MIN_POINTS, settle_circle, tukey_scatter
from tasks.geometry.failure import FitFailure


def fit_robust_circle(section: Section) -> Contour | FitFailure:
    """Fit a circle by orthogonal distances, with points off the contour left out softly.

    Lean and taper within the slice are taken out first. The start is a least median of distances, the scale a median
    absolute residual that is estimated again with every fit, the weights are Tukey's (cut 6 sigma).

    The covariance is A / B^2 times the inverse normal matrix of the used points: A the mean squared influence with
    n - 3 degrees of freedom, B the mean slope of the influence, both from the residuals. It thus contains the price
    of robustness (1/0.98 at normal noise). It takes the points as independent.

    References
    ----------
    Huber 1981, Robust Statistics, section 7.6 (covariance); docs/estimators.md.
    """
    straight = straighten(section)
    start = resistant_circle(straight)
    if isinstance(start, FitFailure):
        return start
    fit = settle_circle(straight, start)
    if isinstance(fit, FitFailure):
        return fit
    scatter = tukey_scatter(straight.residuals(fit.circle), fit.sigma_m)
    if isinstance(scatter, FitFailure):
        return scatter
    return contour_of(straight, fit.circle, scatter)


CONTOUR: Final = ContourModel(
    "robust_circle",
    "circle of orthogonal distances with Tukey weights",
    min_points=MIN_POINTS,
    fit=fit_robust_circle,
)
