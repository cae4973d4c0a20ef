"""Algebraic circles: A (x^2 + y^2) + B x + C y + D = 0 of least squares under a quadratic constraint."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle, center_distances
from tasks.contours.circle_fit import contour_of, scatter_of_all
from tasks.contours.section import Contour, Section
from tasks.contours.straightening import StraightSection, straighten
from tasks.geometry.failure import FitFailure

Solver = Callable[[NDArray[np.float64]], Circle | FitFailure]
"""From points (n, 2), metres, to a circle."""

EXACT: Final = 1e-12
"""Smallest over largest singular value below which the points lie on a circle to the last digit."""

STEP: Final = 1e-12
"""A circle that moves by less than this part of its radius when the taper is taken out again has settled."""

MOST_TURNS: Final = 30
"""Turns before that counts as not converged: each takes off the share of the widening in the radius."""


def fit_algebraic(section: Section, solve: Solver) -> Contour | FitFailure:
    """Make a contour with an algebraic circle, lean and taper within the slice taken out first.

    The covariance is that of orthogonal distances, with the residual variance on n - 3 degrees of freedom: to first
    order in the noise all algebraic circles share it [Al-Sharadqah & Chernov 2009, section 5]. Every point counts the
    same, and the points are taken as independent.
    """
    straight = straighten(section)
    circle = _without_taper(straight, solve)
    if isinstance(circle, FitFailure):
        return circle
    return contour_of(straight, circle, scatter_of_all(straight.residuals(circle)))


def constrained_circle(xy_m: NDArray[np.float64], constraint: NDArray[np.float64]) -> Circle | FitFailure:
    """Fit a circle to points (n, 2), n >= 3, whose vector a = (A, B, C, D) has the least |Z a| at a' N a = 1.

    The points are moved to their mean and scaled to a mean square of 1. With Z = U S V' the vector is V y / S, y being
    the eigenvector of S V' N^-1 V S with the smallest positive eigenvalue; Z' Z, which costs half of the digits, is
    never made.

    Parameters
    ----------
    xy_m : (n, 2) array
        Points, metres.
    constraint : (4, 4) array
        N for points with mean 0 and mean square 1: regular, with one negative eigenvalue.

    References
    ----------
    Al-Sharadqah & Chernov 2009, doi 10.1214/09-EJS419, section 8 (singular value form).
    """
    mean = xy_m.mean(axis=0)
    scale = float(np.sqrt(np.mean(np.sum((xy_m - mean) ** 2, axis=1))))
    x, y = ((xy_m - mean) / scale).T
    # the triangle of QR has the singular vectors of the tall matrix at a fraction of the cost
    triangle = np.linalg.qr(np.column_stack([x * x + y * y, x, y, np.ones_like(x)]), mode="r")
    square = np.vstack([triangle, np.zeros((4 - len(triangle), 4))])
    singular, v = np.linalg.svd(square)[1:]
    vector = v[3]
    if singular[3] > EXACT * singular[0]:
        inner = singular[:, None] * (v @ np.linalg.solve(constraint, v.T)) * singular
        # the one negative eigenvalue of the constraint comes first
        vector = v.T @ (np.linalg.eigh(inner)[1][:, 1] / singular)
        vector = vector / np.linalg.norm(vector)
    A, B, C, D = vector
    discriminant = B * B + C * C - 4 * A * D
    if abs(A) <= np.finfo(float).eps or discriminant <= 0.0:
        return FitFailure(f"needs points around a contour, got {len(x)} on one line")
    radius = scale * float(np.sqrt(discriminant)) / (2 * abs(float(A)))
    circle = Circle(float(mean[0] - scale * B / (2 * A)), float(mean[1] - scale * C / (2 * A)), radius)
    return circle if circle.finite else FitFailure("needs points around a contour, got no finite circle")


def _without_taper(straight: StraightSection, solve: Solver) -> Circle | FitFailure:
    """Fit, move every point towards the centre by its widening, and fit again until the circle stays."""
    circle = solve(straight.xy_m)
    if not straight.widening_m.any():
        return circle
    for _ in range(MOST_TURNS):
        if isinstance(circle, FitFailure):
            return circle
        before, circle = circle, solve(_narrowed(straight, circle))
        if isinstance(circle, Circle) and _moved(before, circle) <= STEP * circle.radius_m:
            return circle
    return FitFailure(f"circle did not settle in {MOST_TURNS} turns of taking the taper out")


def _narrowed(straight: StraightSection, circle: Circle) -> NDArray[np.float64]:
    """Points (n, 2) moved along their radius to the reference height of the slice."""
    length = np.maximum(center_distances(straight.xy_m, circle), np.finfo(float).tiny)
    outward = (straight.xy_m - [circle.east_m, circle.north_m]) / length[:, None]
    return np.asarray(straight.xy_m - straight.widening_m[:, None] * outward)


def _moved(before: Circle, after: Circle) -> float:
    return max(
        abs(after.east_m - before.east_m),
        abs(after.north_m - before.north_m),
        abs(after.radius_m - before.radius_m),
    )
