"""Contour model ``pratt``: Pratt's algebraic circle."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.algebraic import constrained_circle, fit_algebraic
from tasks.contours.circle import Circle
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.geometry.failure import FitFailure

CONSTRAINT: Final = np.array(
    [[0.0, 0.0, 0.0, -2.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [-2.0, 0.0, 0.0, 0.0]]
)
"""B^2 + C^2 - 4 A D = 1."""


def fit_pratt(section: Section) -> Contour | FitFailure:
    """Fit Pratt's circle: nearly unbiased on arcs, not robust."""
    return fit_algebraic(section, pratt_circle)


def pratt_circle(xy_m: NDArray[np.float64]) -> Circle | FitFailure:
    """Fit Pratt's algebraic circle to points (n, 2), n >= 3, metres.

    References
    ----------
    Pratt 1987, SIGGRAPH Computer Graphics 21.
    """
    return constrained_circle(xy_m, CONSTRAINT)


CONTOUR: Final = ContourModel(
    "pratt", "algebraic circle after Pratt, nearly unbiased on arcs", min_points=4, fit=fit_pratt
)
