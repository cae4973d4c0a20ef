"""A slice with its lean and taper taken out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle, center_distances
from tasks.contours.section import Section


@dataclass(frozen=True, slots=True, eq=False)
class StraightSection:
    """Points of a slice moved to its reference height along the lean.

    Attributes
    ----------
    xy_m : (n, 2) array
        Points about ``origin_m``, metres.
    widening_m : (n,) array
        How much larger the shaft's radius is at the point's own height than at the reference height, metres.
    origin_m : (2,) array
        Mean of the points, site frame, metres: taken off so that large coordinates cost no digits.
    """

    xy_m: NDArray[np.float64]
    widening_m: NDArray[np.float64]
    origin_m: NDArray[np.float64]

    def residuals(self, circle: Circle) -> NDArray[np.float64]:
        """Distances (n,) of the points from a circle at the reference height, outward positive, metres."""
        return center_distances(self.xy_m, circle) - self.widening_m - circle.radius_m


def straighten(section: Section) -> StraightSection:
    """Take lean and taper out of a slice: a thick slice of a leaning cone becomes a ring."""
    rise = section.points_m[:, 2] - section.z_m
    lean = np.array([section.lean_east, section.lean_north])
    origin = section.points_m[:, :2].mean(axis=0)
    xy = section.points_m[:, :2] - origin - rise[:, None] * lean
    # column by column in memory: every use takes east and north apart
    return StraightSection(np.asfortranarray(xy), section.taper * rise, origin)


def flatten(section: Section) -> StraightSection:
    """Drop a slice on the plane as it is: what a plumb cylinder sees, lean and taper stay in."""
    origin = section.points_m[:, :2].mean(axis=0)
    xy = section.points_m[:, :2] - origin
    return StraightSection(np.asfortranarray(xy), np.zeros(len(xy)), origin)
