"""Contour model ``kasa``: the algebraic circle of the paper, eq. 3 to 9."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle, arc_coverage_deg, center_distances
from tasks.contours.circle_fit import circle_noise_m
from tasks.contours.model import ContourModel
from tasks.contours.section import Contour, Section
from tasks.geometry.failure import FitFailure


@dataclass(frozen=True, slots=True, eq=False)
class KasaFit:
    """The circle of eq. 8 and the (2, 2) covariance of its centre, square metres."""

    circle: Circle
    covariance_m2: NDArray[np.float64]


def fit_kasa(section: Section) -> Contour | FitFailure:
    """Fit x^2 + y^2 + D x + E y + F = 0 to the points projected on the plane, by least squares.

    Nothing is straightened, weighted or rejected. On arcs below a half circle the circle shrinks towards the arc
    (docs/estimators.md); the covariance does not cover that bias.

    References
    ----------
    Zhou et al. 2025, eq. 3 to 9.
    """
    xy = section.points_m[:, :2]
    origin = xy.mean(axis=0)
    local = xy - origin
    fit = kasa_circle(local)
    if isinstance(fit, FitFailure):
        return fit
    circle = fit.circle
    distances = center_distances(local, circle) - circle.radius_m
    return Contour(
        center_east_m=float(origin[0] + circle.east_m),
        center_north_m=float(origin[1] + circle.north_m),
        radius_m=circle.radius_m,
        covariance_m2=fit.covariance_m2,
        rmse_m=float(np.sqrt(np.mean(distances**2))),
        n_used=len(local),
        arc_coverage_deg=arc_coverage_deg(local, circle),
        noise_m=circle_noise_m(distances),
    )


def kasa_circle(xy_m: NDArray[np.float64]) -> KasaFit | FitFailure:
    """Solve eq. 6 for D, E, F by QR on centred and scaled points: the same minimum as eq. 7, without its rounding.

    The covariance is that of linear least squares: residual variance of eq. 6 with n - 3 degrees of freedom times
    the inverse normal matrix, and a = -D/2, b = -E/2.

    Parameters
    ----------
    xy_m : (n, 2) array
        Points, metres, n >= 4.
    """
    mean = xy_m.mean(axis=0)
    scale = float(np.sqrt(np.mean((xy_m - mean) ** 2)))
    x, y = ((xy_m - mean) / scale).T
    A = np.asfortranarray(np.column_stack([x, y, np.ones_like(x)]))
    g = -(x * x + y * y)
    q, r = np.linalg.qr(A)
    if np.abs(np.diag(r)).min() <= len(x) * np.finfo(float).eps * np.abs(r).max():
        return FitFailure(f"needs points around a contour, got {len(x)} on one line")
    D, E, F = np.linalg.solve(r, q.T @ g)
    residual = A @ np.array([D, E, F]) - g
    root = np.linalg.inv(r)
    variance = float(residual @ residual) / (len(x) - 3)
    a, b = -D / 2, -E / 2
    radius = scale * float(np.sqrt(a * a + b * b - F))
    circle = Circle(float(mean[0] + scale * a), float(mean[1] + scale * b), radius)
    if not circle.finite:
        return FitFailure("needs points around a contour, got points without a circle of finite radius")
    return KasaFit(circle, scale**2 * variance / 4 * (root @ root.T)[:2, :2])


CONTOUR: Final = ContourModel(
    "kasa", "algebraic least-squares circle of the paper, eq. 4 to 8", min_points=4, fit=fit_kasa
)
