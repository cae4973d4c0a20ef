"""Contour model ``hyper``: the algebraic circle without essential bias."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.algebraic import constrained_circle, fit_algebraic
from tasks.contours.circle import Circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.geometry.failure import FitFailure

CONSTRAINT: Final = np.array(
    [[8.0, 0.0, 0.0, 2.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [2.0, 0.0, 0.0, 0.0]]
)
"""Twice Taubin's constraint minus Pratt's, for points with mean 0 and mean square 1."""


def fit_hyper(section: Section) -> Contour | FitFailure:
    """Fit the hyper-accurate circle: no essential bias on arcs, not robust."""
    return fit_algebraic(section, hyper_circle)


def hyper_circle(xy_m: NDArray[np.float64]) -> Circle | FitFailure:
    """Fit the hyper-accurate algebraic circle to points (n, 2), n >= 3, metres.

    References
    ----------
    Al-Sharadqah & Chernov 2009, doi 10.1214/09-EJS419, section 7.
    """
    return constrained_circle(xy_m, CONSTRAINT)


CONTOUR: Final = ContourModel(
    "hyper", "algebraic circle without essential bias (hyper fit)", min_points=4, fit=fit_hyper
)
