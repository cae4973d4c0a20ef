"""Contour model ``geometric_circle``: least orthogonal distances, for clean sections."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle
from tasks.contours.circle_adjustment import LEAST_SQUARES, adjust_circle
from tasks.contours.circle_fit import contour_of, scatter_of_all
from tasks.contours.circle_start import taubin_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import StraightSection, straighten
from tasks.geometry.failure import FitFailure


def fit_geometric_circle(section: Section) -> Contour | FitFailure:
    """Fit the circle with the least sum of squared orthogonal distances: efficient, not robust.

    References
    ----------
    Chernov & Lesort, arXiv cs/0301001; Al-Sharadqah & Chernov 2009, doi 10.1214/09-EJS419.
    """
    return least_squares_contour(straighten(section))


def least_squares_contour(section: StraightSection) -> Contour | FitFailure:
    """The contour of the circle with the least sum of squared distances, n > 3."""
    circle = least_squares_circle(section)
    if isinstance(circle, FitFailure):
        return circle
    return contour_of(section, circle, scatter_of_all(section.residuals(circle)))


def least_squares_circle(section: StraightSection) -> Circle | FitFailure:
    """The circle with the least sum of squared distances from a slice, about its origin, n >= 3."""
    start = taubin_circle(section.xy_m)
    return start if isinstance(start, FitFailure) else adjust_circle(section, start, LEAST_SQUARES)


def geometric_circle(xy_m: NDArray[np.float64]) -> Circle | FitFailure:
    """Fit the circle with the least sum of squared orthogonal distances to points (n, 2), n >= 3, metres."""
    origin = xy_m.mean(axis=0)
    local = least_squares_circle(StraightSection(xy_m - origin, np.zeros(len(xy_m)), origin))
    if isinstance(local, FitFailure):
        return local
    return Circle(float(origin[0] + local.east_m), float(origin[1] + local.north_m), local.radius_m)


CONTOUR: Final = ContourModel(
    "geometric_circle", "circle of least squared orthogonal distances", min_points=4, fit=fit_geometric_circle
)
