"""Contour model ``best``: circle, ellipse or harmonics, as coverage and points allow."""

from dataclasses import replace
from typing import Final

import numpy as np

from tasks.contours.circle_adjustment import Tukey
from tasks.contours.ellipse import ellipse_contour, robust_ellipse
from tasks.contours.fourier import ProfileFit, fit_profile, profile_contour
from tasks.contours.model import ContourModel
from tasks.contours.robust_adjustment import RobustFit
from tasks.contours.section import Contour, Section
from tasks.contours.tukey_circle import CUT, MIN_POINTS
from tasks.geometry.failure import FitFailure


def fit_best(section: Section) -> Contour | FitFailure:
    """Fit a circle unless the points show harmonics; then the ellipse if it says the same with fewer words.

    The order of the harmonics is that of ``fourier``, with its rules for arcs. Where there are any, an ellipse is fitted
    to the same points, and the Bayesian information criterion decides, from Tukey's loss at one scale for both. On a
    round shaft the centre is that of ``robust_circle``. ``Contour.model`` and ``Contour.reason`` say what was chosen.

    References
    ----------
    Machado 1993, Econometric Theory 9 (criterion with a robust loss).
    """
    profile = fit_profile(section)
    if isinstance(profile, FitFailure):
        return profile
    if profile.order == 0:
        return profile_contour(profile)
    ellipse = robust_ellipse(profile.straight, profile.sigma)
    if isinstance(ellipse, FitFailure):
        return profile_contour(profile)
    over = _bic_over(ellipse, profile)
    against = f"{profile.reason}; ellipse: BIC {over:+.1f} against fourier {profile.order}"
    if over <= 0.0:
        contour = ellipse_contour(profile.straight, ellipse)
        if isinstance(contour, Contour):
            return replace(contour, model="ellipse", reason=against)
    chosen = profile_contour(profile)
    return chosen if isinstance(chosen, FitFailure) else replace(chosen, reason=against)


def _bic_over(ellipse: RobustFit, profile: ProfileFit) -> float:
    """Criterion of an ellipse less that of a profile, for the scale of the profile."""
    sigma = profile.fit.sigma_m
    loss = Tukey(CUT * sigma)
    gain = (loss.cost(ellipse.residuals_m) - loss.cost(profile.fit.residuals_m)) / sigma**2
    fewer = len(ellipse.parameters_m) - len(profile.fit.parameters_m)
    return gain + fewer * float(np.log(profile.fit.used.sum()))


CONTOUR: Final = ContourModel(
    "best",
    "circle, ellipse or fourier, chosen by coverage and BIC",
    min_points=MIN_POINTS,
    fit=fit_best,
)
