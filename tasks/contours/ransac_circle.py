"""Contour model ``ransac_circle``: the circle that most points agree on, then least squares on those points."""

import math
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle
from tasks.contours.circle_fit import Scatter, circle_noise_m, contour_of, scatter_of_all
from tasks.contours.circle_start import centers_through_three, order_along_contour, taubin_circle
from tasks.contours.geometric_circle import least_squares_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import StraightSection, straighten
from tasks.geometry.failure import FitFailure

MIN_POINTS: Final = 8
"""Fewer cannot tell an outlier from the contour."""

SEED: Final = 28
"""Seed of the draws: the same section gives the same circle."""

DRAWS: Final = 100
"""Triples drawn, each with its mirror image: with a third of the points off 60 of the 200 are clean, with half 25."""

JUDGES: Final = 1000
"""Points, evenly taken along the contour, that vote on the candidates."""

CUT: Final = 3.0
"""Threshold in sigmas: beyond it lie 0.3 % of points with normal noise."""

MOST_ROUNDS: Final = 30
"""Rounds of fit and selection before the last one is kept: a point at the threshold may swing for ever."""

SMALLEST_SCALE: Final = 1e-7
"""Scale of noise-free data as a part of the radius: a zero would reject every point but three."""

INSIDE: Final = math.erf(CUT / math.sqrt(2.0))
"""Share of normal residuals within the threshold."""

DENSITY: Final = math.exp(-0.5 * CUT**2) / math.sqrt(2.0 * math.pi)
"""Of the normal distribution at the threshold."""

PRICE: Final = float((INSIDE / (INSIDE - 2.0 * CUT * DENSITY)) ** 2)
"""Variance of the centre over what least squares on the points within the threshold states, 1.06: the points beyond it
are missing both from the scatter and from the pull on the circle."""


def fit_ransac_circle(section: Section) -> Contour | FitFailure:
    """Draw circles through three points, keep the one with most points near it, and fit those by orthogonal distances.

    Lean and taper within the slice are taken out first. The threshold is 3 sigma; sigma comes from the candidate with
    the least median distance, later from the residuals of the fit, and selection and fit are repeated until the
    selection stays. The draws have a fixed seed and follow the order along the contour, so that neither the order of
    the points nor a turn of the section changes them.

    The covariance is that of least squares on the selected points times 1.06, which at normal noise is the price of a
    hard threshold. It takes the points as independent.

    References
    ----------
    Fischler & Bolles 1981, CACM 24; Pleterski et al. 2024, reference [28] of Zhou et al. 2025, as told there (RANSAC
    combined with least squares); Huber 1981, section 7.6 (price).
    """
    straight = straighten(section)
    start = _consensus_circle(straight)
    if isinstance(start, FitFailure):
        return start
    circle, used = start, np.zeros(0, dtype=np.bool_)
    for _ in range(MOST_ROUNDS):
        before, used = used, _inliers(straight, circle)
        if 2 * int(used.sum()) < len(used) or int(used.sum()) < MIN_POINTS:
            return FitFailure(f"needs most points on one circle, got {int(used.sum())} of {len(used)}")
        if np.array_equal(before, used):
            break
        adjusted = least_squares_circle(_part(straight, used))
        if isinstance(adjusted, FitFailure):
            return adjusted
        circle = adjusted
    return contour_of(straight, circle, _scatter(straight.residuals(circle), used))


def _consensus_circle(straight: StraightSection) -> Circle | FitFailure:
    """The drawn circle that most points lie near."""
    order = order_along_contour(straight, taubin_circle(straight.xy_m))
    centers = _drawn_centers(straight, order)
    if not len(centers):
        return FitFailure("needs points around a contour, got points on one line")
    n = len(order)
    judges = _part(straight, order[np.round(np.linspace(0, n - 1, min(n, JUDGES))).astype(np.intp)])
    distances = (
        np.hypot(*(judges.xy_m[None, :, :] - centers[:, None, :]).transpose(2, 0, 1)) - judges.widening_m
    )
    radii = np.median(distances, axis=1)
    misses = np.abs(distances - radii[:, None])
    typical = np.median(misses, axis=1)
    likeliest = int(np.argmin(typical))
    sigma = max(circle_noise_m(misses[likeliest]), SMALLEST_SCALE * float(radii[likeliest]))
    votes = np.count_nonzero(misses < CUT * sigma, axis=1)
    # of equal votes the closer circle wins
    best = int(np.lexsort((typical, -votes))[0])
    circle = Circle(float(centers[best, 0]), float(centers[best, 1]), float(radii[best]))
    return circle if circle.finite else FitFailure("needs points around a contour, got no finite circle")


def _drawn_centers(straight: StraightSection, order: NDArray[np.intp]) -> NDArray[np.float64]:
    """Centres (k, 2) of circles through three points drawn from all."""
    places = np.random.default_rng(SEED).uniform(size=(DRAWS, 3))
    # a mirrored section runs the other way: with 1 - u beside u it meets the same triples
    ranks = (np.vstack([places, 1.0 - places]) * len(order)).astype(np.intp)
    first, second, third = straight.xy_m[order[ranks]].transpose(1, 0, 2)
    return centers_through_three(first, second, third)


def _part(straight: StraightSection, rows: NDArray[np.intp] | NDArray[np.bool_]) -> StraightSection:
    return replace(straight, xy_m=straight.xy_m[rows], widening_m=straight.widening_m[rows])


def _inliers(straight: StraightSection, circle: Circle) -> NDArray[np.bool_]:
    """Points (n,) within the threshold."""
    residuals = straight.residuals(circle)
    sigma = max(circle_noise_m(residuals), SMALLEST_SCALE * circle.radius_m)
    return np.asarray(np.abs(residuals) < CUT * sigma)


def _scatter(residuals_m: NDArray[np.float64], used: NDArray[np.bool_]) -> Scatter:
    inside = scatter_of_all(residuals_m[used])
    return Scatter(used, PRICE * inside.variance_m2, inside.rmse_m, circle_noise_m(residuals_m))


CONTOUR: Final = ContourModel(
    "ransac_circle",
    "RANSAC, then least squares on the points that agree (ref. 28 of the paper)",
    min_points=MIN_POINTS,
    fit=fit_ransac_circle,
)
