"""Rings of points for the tests of the contour models."""

import numpy as np
from numpy.typing import NDArray

from tasks.contours import Section


def ring(
    rng: np.random.Generator,
    n: int = 200,
    arc_deg: float = 360.0,
    sigma_m: float = 0.02,
    radius_m: float = 4.0,
) -> NDArray[np.float64]:
    """Points (n, 3) on an arc about +x with radial noise."""
    angle = np.radians(rng.uniform(-arc_deg / 2, arc_deg / 2, n))
    radius = radius_m + sigma_m * rng.standard_normal(n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), rng.uniform(-0.005, 0.005, n)])


def section_of(points_m: NDArray[np.float64]) -> Section:
    """A thin untapered slice at height 0, all points of the same sigma."""
    return Section(points_m, z_m=0.0, thickness_m=0.01, sigma_m=np.full(len(points_m), 0.02))


def flat_section(xy_m: object) -> Section:
    """A slice from points in the plane."""
    xy = np.asarray(xy_m, dtype=np.float64)
    return section_of(np.column_stack([xy, np.zeros(len(xy))]))
