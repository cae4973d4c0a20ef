"""Contour model ``vertical_cylinder``: a plumb cylinder through the points of a slice, as others measure chimneys."""

from typing import Final

from tasks.contours.geometric_circle import least_squares_contour
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import flatten
from tasks.geometry.failure import FitFailure


def fit_vertical_cylinder(section: Section) -> Contour | FitFailure:
    """Fit a cylinder with a plumb axis to the points in space, by least squared distances from its surface.

    The distance from a plumb cylinder is that in the plan, so the height of a point has no say: lean and taper within
    the slice stay in. Where one side is seen higher than the other the centre moves by the lean times the difference of
    heights, and with a taper on an arc by more; the covariance does not cover that. Thin slices are meant.

    References
    ----------
    Muszynski et al., reference [40] of Zhou et al. 2025, as told there: vertical cylinders by least squares at each
    cross section.
    """
    return least_squares_contour(flatten(section))


CONTOUR: Final = ContourModel(
    "vertical_cylinder",
    "plumb cylinder of least squared distances, nothing straightened (ref. 40 of the paper)",
    min_points=4,
    fit=fit_vertical_cylinder,
)
