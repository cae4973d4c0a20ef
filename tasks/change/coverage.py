"""How far two epochs saw the same of a wall, and so err alike by its form."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

TAPER_ORDER: Final = 1
"""The radius that is fitted along: a cone."""

DENSE: Final = 0.25
"""Pieces with this part of the median number of points count half: beyond, more points say no more of the wall."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenSurface:
    """Pieces of a wall and the points on them.

    ``z_m`` (k,) middle heights, ``azimuth_rad`` (k,) middle azimuths clockwise from north, ``n_points`` (k,).
    """

    z_m: NDArray[np.float64]
    azimuth_rad: NDArray[np.float64]
    n_points: NDArray[np.float64]


def likeness(first: SeenSurface, second: SeenSurface) -> float:
    """Correlation of the errors that one wall causes in the leans of two epochs.

    Each lean follows the form of every piece by a lever of its own, which depends on what else was seen. The form of
    pieces is taken as independent and the same in both epochs, so the correlation is that of the levers. 0 where the
    pieces of the two are not the same ones or nothing was seen.

    Raises
    ------
    ShapeError
        If the arrays of an epoch do not fit together.
    """
    for one in (first, second):
        if not len(one.z_m) == len(one.azimuth_rad) == len(one.n_points):
            raise ShapeError("SeenSurface needs arrays of one length")
    same = len(first.z_m) == len(second.z_m) and np.allclose(first.z_m, second.z_m)
    if not same or not np.allclose(first.azimuth_rad, second.azimuth_rad):
        return 0.0
    a, b = _levers(first), _levers(second)
    if a is None or b is None:
        return 0.0
    scale = np.sqrt(np.sum(a**2) * np.sum(b**2))
    return float(np.clip(np.sum(a * b) / scale, 0.0, 1.0)) if scale > 0.0 else 0.0


def _levers(seen: SeenSurface) -> NDArray[np.float64] | None:
    """How the lean (2, k) follows the form of the pieces; None where they fix no lean."""
    some = seen.n_points > 0.0
    if not some.any():
        return None
    weight = seen.n_points / (seen.n_points + DENSE * float(np.median(seen.n_points[some])))
    share = (seen.z_m - seen.z_m.mean()) / max(float(np.ptp(seen.z_m)), np.finfo(float).tiny)
    east, north = np.sin(seen.azimuth_rad), np.cos(seen.azimuth_rad)
    radius = [share**order for order in range(TAPER_ORDER + 1)]
    design = np.column_stack([east * share, north * share, east, north, *radius])
    normal = design.T @ (design * weight[:, None])
    if np.linalg.cond(normal) > 1e12:
        return None
    return np.asarray(np.linalg.solve(normal, (design * weight[:, None]).T)[:2])
