"""Contour model ``ellipse``: orthogonal distances from an ellipse with Tukey's biweight."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.arc_gaps import arc_gaps
from tasks.contours.circle import Circle, arc_coverage_deg
from tasks.contours.circle_adjustment import Squares
from tasks.contours.circle_start import resistant_circle, taubin_circle
from tasks.contours.ellipse_shape import Ellipse, EllipseShape, ellipse_of
from tasks.contours.ellipse_start import algebraic_ellipse
from tasks.contours.model import ContourModel
from tasks.contours.out_of_round import axis_azimuth_deg
from tasks.contours.robust_adjustment import RobustFit, adjust_shape, relative_sigma, settle_shape
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import StraightSection, straighten
from tasks.contours.tukey_circle import CUT
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import mad_sigma

MIN_POINTS: Final = 12
"""Fewer cannot tell an outlier from the contour: five parameters, and a scale from what is left."""

LOOSEST_CENTRE: Final = 0.01
"""A centre less certain than this part of the radius is refused: the ellipse is then biased by as much as it scatters.

With noise of 10 mm, 400 points and a radius of 4 m this is at about 120 degrees.
"""


def fit_ellipse(section: Section) -> Contour | FitFailure:
    """Fit an ellipse by orthogonal distances, with points off the contour left out softly.

    Lean and taper within the slice are taken out first. The start is the best of a resistant circle and of Halir and
    Flusser's ellipse for all points and for those near that circle, by the median absolute distance; scale, weights and
    covariance are those of ``robust_circle``, with five parameters. The radius is the mean of the half axes.

    An arc that leaves the centre uncertain by more than 1 % of the radius is refused.
    """
    straight = straighten(section)
    sigma = relative_sigma(section.sigma_m, len(straight.xy_m))
    if isinstance(sigma, FitFailure):
        return sigma
    fit = robust_ellipse(straight, sigma)
    return fit if isinstance(fit, FitFailure) else ellipse_contour(straight, fit)


def robust_ellipse(straight: StraightSection, sigma: NDArray[np.float64]) -> RobustFit | FitFailure:
    """Settle an ellipse and a scale on points with relative standard deviations ``sigma`` (n,)."""
    circle = resistant_circle(straight)
    if isinstance(circle, FitFailure):
        return circle
    shape = EllipseShape.of(straight, sigma)
    return settle_shape(shape, _robust_start(straight, shape, circle), np.full(5, np.inf))


def ellipse_contour(straight: StraightSection, fit: RobustFit) -> Contour | FitFailure:
    """Make a contour of a settled ellipse, or say that the arc is too short for it."""
    ellipse = ellipse_of(fit.parameters_m)
    covariance = fit.covariance_m2()[:2, :2]
    used_xy = straight.xy_m[fit.used]
    sigma = float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    if not sigma <= LOOSEST_CENTRE * ellipse.mean_m:
        covered = arc_gaps(used_xy, fit.parameters_m[:2]).covered_deg
        return FitFailure(
            f"arc too short for an ellipse: {covered:.0f} deg of the circumference have points, which fixes the centre "
            f"to {sigma:.3g} m at a radius of {ellipse.mean_m:.3g} m"
        )
    center = Circle(ellipse.east_m, ellipse.north_m, ellipse.mean_m)
    return Contour(
        center_east_m=float(straight.origin_m[0]) + ellipse.east_m,
        center_north_m=float(straight.origin_m[1]) + ellipse.north_m,
        radius_m=ellipse.mean_m,
        covariance_m2=covariance,
        rmse_m=fit.rmse_m,
        n_used=int(fit.used.sum()),
        arc_coverage_deg=arc_coverage_deg(used_xy, center),
        noise_m=fit.sigma_m,
        roundness_m=ellipse.major_m - ellipse.minor_m,
        ovality_m=ellipse.half_difference_m,
        ovality_azimuth_deg=axis_azimuth_deg(ellipse.major_angle_rad),
    )


def geometric_ellipse(xy_m: NDArray[np.float64]) -> Ellipse | FitFailure:
    """Fit the ellipse with the least sum of squared orthogonal distances to points (n, 2), n >= 6, metres.

    References
    ----------
    Gander, Golub & Strebel 1994, BIT 34; Ahn, Rauh & Warnecke 2001, Pattern Recognition 34.
    """
    origin = xy_m.mean(axis=0)
    straight = StraightSection(xy_m - origin, np.zeros(len(xy_m)), origin)
    start: Ellipse | Circle | FitFailure = algebraic_ellipse(straight.xy_m)
    if isinstance(start, FitFailure):
        start = taubin_circle(straight.xy_m)
    if isinstance(start, FitFailure):
        return start
    shape = EllipseShape.of(straight, np.ones(len(xy_m)))
    parameters = start.parameters_m if isinstance(start, Ellipse) else _as_ellipse(start)
    adjusted = adjust_shape(shape, parameters, Squares(), np.zeros(5))
    if isinstance(adjusted, FitFailure):
        return adjusted
    shift = np.concatenate([origin, np.zeros(3)])
    return ellipse_of(adjusted.parameters_m + shift)


def _robust_start(straight: StraightSection, shape: EllipseShape, circle: Circle) -> NDArray[np.float64]:
    """The start (5,) with the least median absolute distance."""
    distances = straight.residuals(circle)
    near = np.abs(distances) <= CUT * mad_sigma(distances)
    starts = [_as_ellipse(circle)]
    for xy in (straight.xy_m, straight.xy_m[near]):
        found = algebraic_ellipse(xy)
        if isinstance(found, Ellipse):
            starts.append(found.parameters_m)
    return min(starts, key=lambda start: _median_distance(shape, start))


def _median_distance(shape: EllipseShape, start_m: NDArray[np.float64]) -> float:
    here = shape.at(start_m)
    return np.inf if here is None else mad_sigma(here.residuals_m)


def _as_ellipse(circle: Circle) -> NDArray[np.float64]:
    return np.array([circle.east_m, circle.north_m, circle.radius_m, 0.0, 0.0])


CONTOUR: Final = ContourModel(
    "ellipse",
    "ellipse of orthogonal distances with Tukey weights; refuses arcs that do not fix it",
    min_points=MIN_POINTS,
    fit=fit_ellipse,
)
