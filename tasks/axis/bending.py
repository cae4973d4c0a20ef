"""How far the centres of a shaft bend off a straight line."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.centres import Centres

LEAST_HEIGHTS: Final = 4
"""Through three heights a parabola always goes: it would say nothing."""


def height_basis(z_m: NDArray[np.float64], lowest_m: float, span_m: float, order: int) -> NDArray[np.float64]:
    """Legendre polynomials of order 0 to ``order`` at heights (m,): (m, order + 1), the range mapped to -1 ... 1.

    Those from the second on are orthogonal to a line over the range, so the first coefficient is the slope of the line
    that fits the curve best, uniformly over the range. The second is the largest distance of a parabola from that line
    (at both ends).
    """
    return np.asarray(np.polynomial.legendre.legvander(2.0 * (z_m - lowest_m) / span_m - 1.0, order))


def bending_m(centres: Centres, weights: NDArray[np.float64]) -> float | None:
    """Largest distance of a least-squares parabola from its own line within the height range, metres.

    None where fewer than 4 different heights have a weight. Noise bends too: the figure of a straight axis is not 0.
    """
    used = weights > 0.0
    if len(np.unique(centres.points_m[used, 2])) < LEAST_HEIGHTS:
        return None
    root = np.sqrt(weights[used])[:, None]
    basis = height_basis(centres.points_m[used, 2], centres.lowest_m, centres.span_m, 2)
    horizontal = centres.points_m[used, :2] - centres.points_m[:, :2].mean(axis=0)
    coefficients = np.linalg.lstsq(basis * root, horizontal * root, rcond=None)[0]
    return float(np.hypot(*coefficients[2]))
