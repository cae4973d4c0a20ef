"""What the scans cannot see of a pose, found in the normal matrix in physical units."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

LEVER_M: Final = 50.0
"""Turns a rotation into a shift, so that both compare: the half height of a tall shaft."""

NAMES: Final = ("level east", "level north", "heading", "shift east", "shift north", "shift up")


def weakest_direction(data_information: NDArray[np.float64]) -> str | None:
    """Name what the scans alone know least of a pose, from its (6, 6) information.

    None where the scans say nothing at all, because no scan overlaps.
    """
    scale = np.array([1.0 / LEVER_M] * 3 + [1.0] * 3)
    values, vectors = np.linalg.eigh(data_information * np.outer(scale, scale))
    if values[-1] <= 0.0:
        return None
    return NAMES[int(np.argmax(np.abs(vectors[:, 0])))]
