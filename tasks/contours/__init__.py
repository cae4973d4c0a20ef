"""Fit the contour of a slice and find its centre (paper 2.2.2 to 2.2.4).

A contour model is one file of this folder that defines ``CONTOUR``; it is found by itself.
"""

from typing import Final

from tasks.contours.model import ContourModel
from tasks.contours.outline import Outline
from tasks.contours.section import Contour, Section
from tasks.geometry.failure import FitFailure
from tasks.geometry.variants import choose, discover

CONTOURS: Final[dict[str, ContourModel]] = discover(__name__, "CONTOUR", ContourModel)
"""The contour models that are shipped, by name."""

__all__ = ["CONTOURS", "Contour", "ContourModel", "Outline", "Section", "fit_contour"]


def fit_contour(name: str, section: Section) -> Contour | FitFailure:
    """Fit the contour model of that name to the points of a slice.

    Parameters
    ----------
    name : str
        A key of ``CONTOURS``.
    section : Section
        The points of the slice and what is known of the shaft around it.

    Returns
    -------
    Contour or FitFailure
        The failure says what the model needed and what came.

    Raises
    ------
    InputError
        If no model has that name.
    """
    model = choose(CONTOURS, name, "contour model")
    unfit = section.unfit_for(model.min_points)
    return unfit if unfit is not None else model.fit(section)
