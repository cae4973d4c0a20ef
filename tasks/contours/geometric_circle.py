"""Contour model ``geometric_circle``: least orthogonal distances, for clean sections."""

from typing import Final

import numpy as np

from tasks.contours.circle_adjustment import Squares, adjust_circle
from tasks.contours.circle_fit import Scatter, contour_of
from tasks.contours.circle_start import taubin_circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import straighten
from tasks.geometry.failure import FitFailure


def fit_geometric_circle(section: Section) -> Contour | FitFailure:
    """Fit the circle with the least sum of squared orthogonal distances: efficient, not robust.

    References
    ----------
    Chernov & Lesort, arXiv cs/0301001; Al-Sharadqah & Chernov 2009, doi 10.1214/09-EJS419.
    """
    straight = straighten(section)
    start = taubin_circle(straight.xy_m)
    if isinstance(start, FitFailure):
        return start
    circle = adjust_circle(straight, start, Squares())
    if isinstance(circle, FitFailure):
        return circle
    residuals = straight.residuals(circle)
    n = len(residuals)
    total = float(residuals @ residuals)
    scatter = Scatter(np.ones(n, dtype=np.bool_), total / (n - 3), float(np.sqrt(total / n)))
    return contour_of(straight, circle, scatter)


CONTOUR: Final = ContourModel(
    "geometric_circle", "circle of least squared orthogonal distances", min_points=4, fit=fit_geometric_circle
)
