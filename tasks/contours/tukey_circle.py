"""A circle and a scale that settle each other under Tukey's biweight."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle
from tasks.contours.circle_adjustment import CircleLoss, adjust_circle
from tasks.contours.circle_fit import Scatter, circle_noise_m
from tasks.contours.straightening import StraightSection
from tasks.geometry.failure import FitFailure

MIN_POINTS: Final = 8
"""Fewer cannot tell an outlier from the contour: three parameters, and a scale from what is left."""

CUT: Final = 6.0
"""Cut in sigmas: efficiency 0.98 at the normal law, where the usual 4.685 leaves 0.95 and a chain of circles and a robust
line 0.88. Ladders and platforms lie beyond both; what is paid with are points 2 to 6 sigmas off the contour (mixed pixels,
brackets), which count more: with a tenth of them the efficiency is 0.74 instead of 0.82."""

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


def settle_circle(
    straight: StraightSection, start: Circle, relative_sigma: NDArray[np.float64] | None = None
) -> TukeyCircle | FitFailure:
    """Turn scale and circle by turns until the scale stays.

    Parameters
    ----------
    straight : StraightSection
        At least ``MIN_POINTS`` points.
    start : Circle
        A circle that outliers have not drawn off.
    relative_sigma : (n,) array or None
        Sigma of each point in units of the scale that is sought; None where all have the same.
    """
    circle, sigma = start, _scale(straight, start, relative_sigma)
    for _ in range(MOST_SCALES):
        adjusted = adjust_circle(straight, circle, CircleLoss(CUT * sigma, relative_sigma), SCALE_STEP)
        if isinstance(adjusted, FitFailure):
            return adjusted
        before, circle, sigma = sigma, adjusted, _scale(straight, adjusted, relative_sigma)
        if abs(sigma - before) <= SCALE_STEP * before:
            break
    final = adjust_circle(straight, circle, CircleLoss(CUT * sigma, relative_sigma))
    return final if isinstance(final, FitFailure) else TukeyCircle(final, sigma)


def tukey_scatter(
    residuals_m: NDArray[np.float64], sigma_m: float, relative_sigma: NDArray[np.float64] | None = None
) -> Scatter | FitFailure:
    """Scatter of residuals (n,) about a settled circle, or say that they do not gather about it.

    The variance is A / B^2: A the mean squared influence with n - 3 degrees of freedom, B the mean slope of the
    influence, both from the residuals of the used points.

    References
    ----------
    Huber 1981, Robust Statistics, section 7.6.
    """
    whitened = residuals_m if relative_sigma is None else residuals_m / relative_sigma
    ratio = np.minimum((whitened / (CUT * sigma_m)) ** 2, 1.0)
    used = ratio < 1.0
    n = int(used.sum())
    if n < MIN_POINTS or 2 * n < len(whitened):
        return FitFailure(f"needs most points on one circle, got {n} of {len(whitened)}")
    weights = (1.0 - ratio[used]) ** 2
    influence = float(np.sum((weights * whitened[used]) ** 2)) / (n - 3)
    slope = float(np.mean((1.0 - ratio[used]) * (1.0 - 5.0 * ratio[used])))
    if slope <= 0.0:
        return FitFailure("needs residuals that gather about a circle, got ones that spread evenly")
    return Scatter(
        used=used,
        variance_m2=influence / slope**2,
        rmse_m=float(np.sqrt(np.mean(residuals_m[used] ** 2))),
        noise_m=circle_noise_m(residuals_m),
        relative_sigma=relative_sigma,
    )


def _scale(straight: StraightSection, circle: Circle, relative_sigma: NDArray[np.float64] | None) -> float:
    """Scale of the whitened residuals, metres."""
    residuals = straight.residuals(circle)
    whitened = residuals if relative_sigma is None else residuals / relative_sigma
    return max(circle_noise_m(whitened), SMALLEST_SCALE * circle.radius_m)
