"""What the scans cannot see of a pose, found in the normal matrix in physical units."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX

LEVER_M: Final = 100.0
"""Turns a rotation about the scanner into a shift where the neighbours look, so that both compare: about the
distance from the scanner to what it shares with them."""

NAMES: Final = ("level east", "level north", "heading", "shift east", "shift north", "shift up")


def weakest_direction(data: NDArray[np.float64], prior: NDArray[np.float64], station: int) -> str | None:
    """Name what the scans know least of a pose, given that the other poses are known no better than they are.

    ``data`` and ``prior`` are the informations (6n, 6n) of scans and of stated poses. The other stations are
    eliminated (Schur complement) with their priors, the station itself stands on the scans alone. None where the
    scans say nothing at all, because no scan overlaps.
    """
    own = np.arange(SIX * station, SIX * station + SIX)
    others = np.setdiff1d(np.arange(len(data)), own)
    coupling = data[np.ix_(own, others)]
    joint = data[np.ix_(others, others)] + prior[np.ix_(others, others)]
    data_information = data[np.ix_(own, own)] - coupling @ np.linalg.solve(joint, coupling.T)
    scale = np.array([1.0 / LEVER_M] * 3 + [1.0] * 3)
    vectors = np.linalg.eigh(data_information * np.outer(scale, scale)).eigenvectors
    if not np.any(data[np.ix_(own, own)]):
        return None
    return NAMES[int(np.argmax(np.abs(vectors[:, 0])))]
