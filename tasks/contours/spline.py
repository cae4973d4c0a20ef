"""Contour model ``spline``: a smooth closed curve, for full rings only."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.arc_gaps import ArcGaps, arc_gaps
from tasks.contours.circle import Circle, arc_coverage_deg
from tasks.contours.circle_start import resistant_circle
from tasks.contours.model import ContourModel
from tasks.contours.out_of_round import out_of_round
from tasks.contours.profile import Harmonics, ProfileShape, profile_start
from tasks.contours.robust_adjustment import RobustFit, relative_sigma, settle_shape
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import StraightSection, straighten
from tasks.geometry.failure import FitFailure

CURVE: Final = Harmonics(12)
"""Where the series of the spline ends: waves of 30 degrees, 2 m on a shaft of 4 m; what is beyond has little variance."""

MIN_POINTS: Final = 2 * (3 + CURVE.count)
"""Two points a parameter: a scale is left."""

WIDEST_GAP_DEG: Final = 20.0
"""Widest gap that a smooth curve may bridge, degrees: two thirds of its shortest wave."""

SMOOTHNESS: Final = 10.0 ** np.arange(-5.0, -0.9, 0.5)
"""Standard deviations of the second derivative of each harmonic that are tried, as parts of the radius."""


def fit_spline(section: Section) -> Contour | FitFailure:
    """Fit a periodic cubic smoothing spline r(theta) about the centre from which it has no first harmonic.

    That centre is the one of ``fourier``, so that the two agree, and it is linear in the points; the centroid of the area
    also moves with products of harmonics, by about a_2 a_3 / R.

    Lean and taper within the slice are taken out first. The curve with the least squares plus a multiple of the integral
    of r'' squared is a spline; here it is written as its Fourier series up to harmonic 12, where the integral is a sum of
    k^4 (a_k^2 + b_k^2), so that no knots stand in any direction. The multiple is the one that makes the points likeliest.
    Start, scale, weights and covariance are those of ``robust_circle``, jointly with the curve.

    A circumference with a gap above 20 degrees is refused: a smooth curve across a gap is a guess. Points more than about
    five sigmas off, such as those of a deep dent, are left out like those of a ladder, and leave a gap.

    References
    ----------
    Wahba 1990, Spline Models for Observational Data, section 2.1 (periodic splines as series).
    """
    straight = straighten(section)
    sigma = relative_sigma(section.sigma_m, len(straight.xy_m))
    if isinstance(sigma, FitFailure):
        return sigma
    start = resistant_circle(straight)
    if isinstance(start, FitFailure):
        return start
    round_one = Harmonics(0)
    circle = settle_shape(
        ProfileShape.of(straight, sigma, round_one), profile_start(start, round_one), np.full(3, np.inf)
    )
    if isinstance(circle, FitFailure):
        return circle
    unseen = _unseen(arc_gaps(straight.xy_m[circle.used], circle.parameters_m[:2]))
    return _closed(straight, sigma, circle) if unseen is None else unseen


def _closed(straight: StraightSection, sigma: NDArray[np.float64], circle: RobustFit) -> Contour | FitFailure:
    """Bend a settled circle to the curve that the points make likeliest."""
    start_m = np.concatenate([circle.parameters_m, np.zeros(CURVE.count)])
    rough = _settle(straight, sigma, start_m, float(SMOOTHNESS[-1]))
    if isinstance(rough, FitFailure):
        return rough
    smooth = _settle(straight, sigma, rough.parameters_m, _likeliest(rough))
    if isinstance(smooth, FitFailure):
        return smooth
    # what the circle left out does not close a gap, and what the curve leaves out may open one
    unseen = _unseen(arc_gaps(straight.xy_m[smooth.used], smooth.parameters_m[:2]))
    return _contour(straight, smooth) if unseen is None else unseen


def _settle(
    straight: StraightSection, sigma: NDArray[np.float64], start_m: NDArray[np.float64], smoothness: float
) -> RobustFit | FitFailure:
    shape = ProfileShape.of(straight, sigma, CURVE)
    return settle_shape(shape, start_m, np.concatenate([np.full(3, np.inf), _prior_sd(smoothness, start_m)]))


def _prior_sd(smoothness: float, parameters_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Standard deviations (count,) of the coefficients whose second derivatives have ``smoothness`` radii."""
    return np.asarray(smoothness * parameters_m[2] / CURVE.numbers**2)


def _likeliest(rough: RobustFit) -> float:
    """Smoothness whose marginal likelihood, linearised at a rough fit, is largest."""
    jacobian = rough.jacobian[:, rough.used]
    inverse = np.linalg.inv(jacobian @ jacobian.T)
    free = (rough.parameters_m - inverse @ (jacobian @ rough.residuals_m[rough.used]))[3:]
    error = rough.variance_m2 * inverse[3:, 3:]
    costs = []
    for smoothness in SMOOTHNESS:
        spread = error + np.diag(_prior_sd(smoothness, rough.parameters_m) ** 2)
        costs.append(np.linalg.slogdet(spread)[1] + free @ np.linalg.solve(spread, free))
    return float(SMOOTHNESS[int(np.argmin(costs))])


def _unseen(gaps: ArcGaps) -> FitFailure | None:
    if gaps.widest_deg <= WIDEST_GAP_DEG:
        return None
    return FitFailure(
        f"needs points all around with no gap above {WIDEST_GAP_DEG:g} deg for a spline; "
        f"got {gaps.covered_deg:.0f} deg with a gap of {gaps.widest_deg:.0f}"
    )


def _contour(straight: StraightSection, fit: RobustFit) -> Contour:
    east, north, radius = (float(value) for value in fit.parameters_m[:3])
    shape = out_of_round(CURVE, fit.parameters_m[3:])
    return Contour(
        center_east_m=float(straight.origin_m[0]) + east,
        center_north_m=float(straight.origin_m[1]) + north,
        radius_m=radius,
        covariance_m2=fit.covariance_m2()[:2, :2],
        rmse_m=fit.rmse_m,
        n_used=int(fit.used.sum()),
        arc_coverage_deg=arc_coverage_deg(straight.xy_m[fit.used], Circle(east, north, radius)),
        noise_m=fit.sigma_m,
        roundness_m=shape.roundness_m,
        ovality_m=shape.ovality_m,
        ovality_azimuth_deg=shape.ovality_azimuth_deg,
    )


CONTOUR: Final = ContourModel(
    "spline",
    "periodic smoothing spline r(theta) with Tukey weights, for full rings; refuses gaps above 20 degrees",
    min_points=MIN_POINTS,
    fit=fit_spline,
)
