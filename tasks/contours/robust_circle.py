"""Contour model ``robust_circle``: orthogonal distances with Tukey's biweight."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle
from tasks.contours.circle_adjustment import Tukey, adjust_circle
from tasks.contours.circle_fit import Scatter, contour_of
from tasks.contours.circle_start import resistant_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import StraightSection, straighten
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import TUKEY_1D, mad_sigma

MIN_POINTS: Final = 8
"""Fewer cannot tell an outlier from the contour: three parameters, and a scale from what is left."""

SCALE_STEP: Final = 1e-6
"""The scale counts as settled when it changes by less than this part of itself."""

MOST_SCALES: Final = 30
"""Scales tried before the last one is kept: a median may swing between two points for ever."""

SMALLEST_SCALE: Final = 1e-7
"""Scale of noise-free data as a part of the radius: a zero would reject every point but three."""


@dataclass(frozen=True, slots=True)
class TukeyCircle:
    """A circle at the minimum of Tukey's loss and the scale that belongs to it, metres."""

    circle: Circle
    sigma_m: float


def fit_robust_circle(section: Section) -> Contour | FitFailure:
    """Fit a circle by orthogonal distances, with points off the contour left out softly.

    Lean and taper within the slice are taken out first. The start is a least median of distances, the scale a median
    absolute residual that is estimated again with every fit, the weights are Tukey's (cut 4.685 sigma).

    The covariance is A / B^2 times the inverse normal matrix of the used points: A the mean squared influence with
    n - 3 degrees of freedom, B the mean slope of the influence, both from the residuals. It thus contains the price
    of robustness (1/0.95 at normal noise). It takes the points as independent.

    References
    ----------
    Huber 1981, Robust Statistics, section 7.6 (covariance); docs/estimators.md.
    """
    straight = straighten(section)
    start = resistant_circle(straight)
    if isinstance(start, FitFailure):
        return start
    fit = _settle(straight, start)
    if isinstance(fit, FitFailure):
        return fit
    scatter = _scatter(straight.residuals(fit.circle), fit.sigma_m)
    if isinstance(scatter, FitFailure):
        return scatter
    return contour_of(straight, fit.circle, scatter)


def _settle(straight: StraightSection, start: Circle) -> TukeyCircle | FitFailure:
    """Turn scale and circle by turns until the scale stays."""
    circle, sigma = start, _scale(straight, start)
    for _ in range(MOST_SCALES):
        adjusted = adjust_circle(straight, circle, Tukey(TUKEY_1D * sigma), SCALE_STEP)
        if isinstance(adjusted, FitFailure):
            return adjusted
        before, circle, sigma = sigma, adjusted, _scale(straight, adjusted)
        if abs(sigma - before) <= SCALE_STEP * before:
            break
    final = adjust_circle(straight, circle, Tukey(TUKEY_1D * sigma))
    return final if isinstance(final, FitFailure) else TukeyCircle(final, sigma)


def _scale(straight: StraightSection, circle: Circle) -> float:
    """Scale from the median absolute residual, freed of what three parameters absorb, metres."""
    n = len(straight.xy_m)
    return max(
        mad_sigma(straight.residuals(circle)) * float(np.sqrt(n / (n - 3))), SMALLEST_SCALE * circle.radius_m
    )


def _scatter(residuals: NDArray[np.float64], sigma_m: float) -> Scatter | FitFailure:
    ratio = np.minimum((residuals / (TUKEY_1D * sigma_m)) ** 2, 1.0)
    used = ratio < 1.0
    n = int(used.sum())
    if n < MIN_POINTS or 2 * n < len(residuals):
        return FitFailure(f"needs most points on one circle, got {n} of {len(residuals)}")
    inside = residuals[used]
    weights = (1.0 - ratio[used]) ** 2
    influence = float(np.sum((weights * inside) ** 2)) / (n - 3)
    slope = float(np.mean((1.0 - ratio[used]) * (1.0 - 5.0 * ratio[used])))
    if slope <= 0.0:
        return FitFailure("needs residuals that gather about a circle, got ones that spread evenly")
    return Scatter(used, influence / slope**2, float(np.sqrt(np.mean(inside**2))))


CONTOUR: Final = ContourModel(
    "robust_circle",
    "circle of orthogonal distances with Tukey weights",
    min_points=MIN_POINTS,
    fit=fit_robust_circle,
)
