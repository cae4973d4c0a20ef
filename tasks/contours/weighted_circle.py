"""Contour model ``weighted_circle``: orthogonal distances over the sigma of each point, with Tukey's biweight."""

from typing import Final

import numpy as np

from tasks.contours.circle_fit import contour_of
from tasks.contours.circle_start import resistant_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import straighten
from tasks.contours.tukey_circle import MIN_POINTS, settle_circle, tukey_scatter
from tasks.geometry.failure import FitFailure


def fit_weighted_circle(section: Section) -> Contour | FitFailure:
    """Fit a circle as ``robust_circle`` does, every point with the weight 1 / sigma^2 of its line of sight.

    Only ratios of the sigmas matter: their scale is estimated from the residuals, in units of the sigmas, and the cut
    of the biweight counts in each point's own sigma. The covariance follows from both; it takes the points as
    independent and the ratios as known.

    References
    ----------
    Huber 1981, Robust Statistics, section 7.6 (covariance); docs/estimators.md.
    """
    sigma_m = section.sigma_m
    if sigma_m is None:
        return FitFailure("needs the sigma of every point, got points whose stations are not known")
    bad = len(sigma_m) - int(np.count_nonzero(np.isfinite(sigma_m) & (sigma_m > 0.0)))
    if bad:
        return FitFailure(f"needs a finite sigma above 0 for every point, got {bad} points without")
    relative = sigma_m / np.median(sigma_m)
    straight = straighten(section)
    start = resistant_circle(straight)
    if isinstance(start, FitFailure):
        return start
    fit = settle_circle(straight, start, relative)
    if isinstance(fit, FitFailure):
        return fit
    scatter = tukey_scatter(straight.residuals(fit.circle), fit.sigma_m, relative)
    if isinstance(scatter, FitFailure):
        return scatter
    return contour_of(straight, fit.circle, scatter)


CONTOUR: Final = ContourModel(
    "weighted_circle",
    "robust circle with points weighted by the noise of their lines of sight",
    min_points=MIN_POINTS,
    fit=fit_weighted_circle,
    weighs_sights=True,
)
