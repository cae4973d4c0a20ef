"""What a contour model is."""

from collections.abc import Callable
from dataclasses import dataclass

from tasks.contours.section import Contour, Section
from tasks.geometry.failure import FitFailure


@dataclass(frozen=True, slots=True)
class ContourModel:
    """A way from the points of a slice to a centre.

    ``fit`` gets at least ``min_points`` finite points that do not lie on one line. A model that ``weighs_sights`` needs
    ``Section.sigma_m``; the others do without.
    """

    name: str
    description: str
    min_points: int
    fit: Callable[[Section], Contour | FitFailure]
    weighs_sights: bool = False
