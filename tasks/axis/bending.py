"""How far the centres of a shaft bend off a straight line."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.centres import Centres
from tasks.axis.forms import Polynomial

LEAST_HEIGHTS: Final = 4
"""Through three heights a parabola always goes: it would say nothing."""

PARABOLA: Final = Polynomial(2)
"""Its second Legendre polynomial is orthogonal to a line over the range, and at most 1 off it, at both ends."""


def bending_m(centres: Centres, weights: NDArray[np.float64]) -> float | None:
    """Largest distance of a least-squares parabola from its own line within the height range, metres.

    None where fewer than 4 different heights have a weight. Noise bends too: the figure of a straight axis is not 0.
    """
    used = weights > 0.0
    if len(np.unique(centres.points_m[used, 2])) < LEAST_HEIGHTS:
        return None
    root = np.sqrt(weights[used])[:, None]
    basis = PARABOLA.values(centres.place(centres.points_m[used, 2]))
    horizontal = centres.points_m[used, :2] - centres.points_m[:, :2].mean(axis=0)
    coefficients = np.linalg.lstsq(basis * root, horizontal * root, rcond=None)[0]
    return float(np.hypot(*coefficients[2]))
