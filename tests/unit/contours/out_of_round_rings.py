"""Rings that are not round, and what stands about them, for the tests of the contour models."""

import numpy as np
from numpy.typing import NDArray

from tasks.contours import Contour, fit_contour
from tests.unit.contours.rings import section_of

RADIUS_M = 4.0
SIGMA_M = 0.01
OVAL_M = 0.03
LOBES_M = 0.02


def profile_ring(
    rng: np.random.Generator,
    arc_deg: float = 360.0,
    oval_m: float = 0.0,
    lobes_m: float = 0.0,
    n: int = 400,
    sigma_m: float = SIGMA_M,
) -> NDArray[np.float64]:
    """Points (n, 3) on an arc about +x whose largest diameter and first of three lobes point to 0.5 rad."""
    angle = np.radians(rng.uniform(-arc_deg / 2, arc_deg / 2, n))
    radius = RADIUS_M + oval_m * np.cos(2 * (angle - 0.5)) + lobes_m * np.cos(3 * (angle - 0.5))
    radius += sigma_m * rng.standard_normal(n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(n)])


def ladder(rng: np.random.Generator, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """A tenth of the points are on a ladder 0.2 to 1.2 m outside, over 30 degrees that hide the wall behind."""
    azimuth = np.degrees(np.arctan2(points_m[:, 1], points_m[:, 0]))
    wall = points_m[(azimuth < 20.0) | (azimuth > 50.0)]
    count = len(points_m) // 10
    angle = np.radians(rng.uniform(20.0, 50.0, count))
    distance = RADIUS_M + rng.uniform(0.2, 1.2, count)
    rungs = np.column_stack([distance * np.cos(angle), distance * np.sin(angle), np.zeros(count)])
    return np.vstack([wall, rungs])


def platform(rng: np.random.Generator, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """A tenth of the points are on a concentric rail 0.8 m outside, at one end of the arc."""
    del rng
    spoiled = points_m.copy()
    end = np.argsort(np.arctan2(points_m[:, 1], points_m[:, 0]))[: len(points_m) // 10]
    spoiled[end, :2] *= 1.2
    return spoiled


def contour(name: str, points_m: NDArray[np.float64]) -> Contour:
    """The contour of a thin slice, which must have one."""
    fit = fit_contour(name, section_of(points_m))
    assert isinstance(fit, Contour), fit
    return fit


def rms_error_m(fits: list[Contour]) -> float:
    """Root mean square distance of the centres from the origin."""
    return float(np.sqrt(np.mean([fit.center_east_m**2 + fit.center_north_m**2 for fit in fits])))


def stated_error_m(fits: list[Contour]) -> float:
    """What the covariances say that distance is."""
    return float(np.sqrt(np.mean([np.trace(fit.covariance_m2) for fit in fits])))


def whitened_rms(fits: list[Contour]) -> float:
    """Root mean square of both components of the error in their own standard deviations; 1 where these are true."""
    squares = [
        error @ np.linalg.solve(fit.covariance_m2, error)
        for fit in fits
        for error in [np.array([fit.center_east_m, fit.center_north_m])]
    ]
    return float(np.sqrt(np.mean(squares) / 2))
