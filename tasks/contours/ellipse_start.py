"""First ellipses: where the iterations begin."""

import numpy as np
from numpy.typing import NDArray

from tasks.contours.ellipse_shape import Ellipse
from tasks.geometry.failure import FitFailure


def algebraic_ellipse(xy_m: NDArray[np.float64]) -> Ellipse | FitFailure:
    """Fit a conic that is an ellipse to points (n, 2), n >= 5, by algebraic least squares, centred and scaled.

    It is biased towards small ellipses on short arcs: a start, not a result.

    References
    ----------
    Halir & Flusser 1998, Numerically stable direct least squares fitting of ellipses, WSCG 98.
    """
    origin = xy_m.mean(axis=0)
    scale = float(np.sqrt(np.mean((xy_m - origin) ** 2)))
    x, y = ((xy_m - origin) / scale).T
    quadratic = np.column_stack([x * x, x * y, y * y])
    linear = np.column_stack([x, y, np.ones_like(x)])
    try:
        to_linear = -np.linalg.solve(linear.T @ linear, linear.T @ quadratic)
    except np.linalg.LinAlgError:
        return FitFailure(f"needs points around a contour, got {len(x)} on one line")
    reduced = quadratic.T @ (quadratic + linear @ to_linear)
    vectors = np.linalg.eig(np.array([reduced[2] / 2, -reduced[1], reduced[0] / 2]))[1].real
    elliptic = 4 * vectors[0] * vectors[2] - vectors[1] ** 2
    best = int(np.argmax(elliptic))
    if not elliptic[best] > 0.0:
        return FitFailure(f"needs points around an ellipse, got {len(x)} on another conic")
    first = vectors[:, best]
    unit = _ellipse_of_conic(np.concatenate([first, to_linear @ first]))
    if isinstance(unit, FitFailure):
        return unit
    return Ellipse(
        float(origin[0]) + scale * unit.east_m,
        float(origin[1]) + scale * unit.north_m,
        scale * unit.mean_m,
        scale * unit.even_m,
        scale * unit.odd_m,
    )


def _ellipse_of_conic(conic: NDArray[np.float64]) -> Ellipse | FitFailure:
    """The ellipse of A x^2 + B x y + C y^2 + D x + E y + F = 0 (6,) with 4 A C > B^2."""
    form = np.array([[conic[0], conic[1] / 2], [conic[1] / 2, conic[2]]])
    slope = conic[3:5]
    center = -np.linalg.solve(form, slope) / 2
    values, axes = np.linalg.eigh(-form / (conic[5] + slope @ center / 2))
    if not values.min() > 0.0:
        return FitFailure("needs points around an ellipse, got an imaginary one")
    root = axes / np.sqrt(values) @ axes.T
    return Ellipse(
        float(center[0]),
        float(center[1]),
        float(np.trace(root)) / 2,
        float(root[0, 0] - root[1, 1]) / 2,
        float(root[0, 1]),
    )
