"""Between which knots a height lies, compiled: for loops over points that come from the bottom up as a rule."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.compiled import compiled


@compiled
def knot_below(knots_m: NDArray[np.float64], z_m: float, knot: int) -> int:
    """Index of the last knot (k,) but one that is not above a height, at least 0; sought from ``knot`` on, up or down."""
    last = len(knots_m) - 2
    while knot < last and z_m >= knots_m[knot + 1]:
        knot += 1
    while knot > 0 and z_m < knots_m[knot]:
        knot -= 1
    return knot
