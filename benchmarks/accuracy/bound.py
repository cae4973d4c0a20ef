"""The Cramer-Rao bound of the lean of sliced points, and the estimate that reaches it.

The unknowns are a straight axis (position and lean, 4) and a radius for every slice. The bound is that of the points on
the shaft of this very trial. ``best_error`` is what the efficient estimate, linear about the truth, is off by: it scatters
exactly as the bound says, and with it the luck of the draw is taken out of a Monte Carlo.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.sliced_shaft import Drawn


@dataclass(frozen=True, slots=True, eq=False)
class Bound:
    """Covariance (2, 2) of the lean that no unbiased estimate can undercut, and the error (2,) of the best estimate."""

    covariance: NDArray[np.float64]
    best_error: NDArray[np.float64]


def bound_of(drawn: Drawn) -> Bound:
    """Bound of the points of a trial that lie on the shaft."""
    u = np.stack([np.cos(drawn.angle_rad), np.sin(drawn.angle_rad), np.ones_like(drawn.angle_rad)], axis=-1)
    weight = drawn.clean / drawn.sigma_m**2
    normal = np.einsum("jn,jna,jnb->jab", weight, u, u)
    score = np.einsum("jn,jna->ja", weight * drawn.error_m, u)
    # a radius of its own for every slice drops out of it
    cross, last = normal[:, :2, 2], normal[:, 2, 2]
    centre = normal[:, :2, :2] - cross[:, :, None] * cross[:, None, :] / last[:, None, None]
    pull = score[:, :2] - cross * (score[:, 2] / last)[:, None]
    height = np.stack([np.ones_like(drawn.z_m), drawn.z_m - drawn.z_m.mean()], axis=-1)
    information = np.einsum("jk,jl,jab->kalb", height, height, centre).reshape(4, 4)
    right = np.einsum("jk,ja->ka", height, pull).reshape(4)
    covariance = np.linalg.inv(information)
    return Bound(covariance[2:, 2:], (covariance @ right)[2:])
