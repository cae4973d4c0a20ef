"""The directions in which straight edges of points run, where edges repeat at equal angles."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

STEP_RAD: Final = float(np.radians(0.5))
"""Distance of tried directions: it moves the end of an edge of 3 m by 13 mm at most."""

APART_RAD: Final = float(np.radians(3.0))
"""Directions nearer than this are one."""


def edge_directions(
    xy: NDArray[np.float64],
    group: NDArray[np.intp],
    n_sides: int,
    width: float,
    n_answers: int,
) -> NDArray[np.float64]:
    """Azimuths (at most ``n_answers``,) of normals, in [0, 2 pi / n_sides), that gather points into edges best.

    A direction is good where few strips of ``width`` hold many points of one group each (a band of height): the sum
    of the squares of their counts.

    Parameters
    ----------
    xy : (n, 2) array
        Points, n at least 1.
    group : (n,) array
        Group of each, from 0.
    n_sides : int
        Normals repeat every 2 pi / n_sides.
    """
    period = 2.0 * np.pi / n_sides
    tried = np.arange(0.0, period, STEP_RAD)
    x, y = (xy - xy.mean(axis=0)).T
    reach = float(np.hypot(x, y).max())
    n_strips = int(np.ceil(2.0 * reach / width)) + 1
    # opposite normals share their strips
    turns = [k * period for k in range(max(n_sides // 2, 1) if n_sides % 2 == 0 else n_sides)]
    gathered = np.zeros(len(tried))
    for i, azimuth in enumerate(tried):
        for turn in turns:
            across = x * np.sin(azimuth + turn) + y * np.cos(azimuth + turn)
            strip = ((across + reach) / width).astype(np.intp)
            counts = np.bincount(group * n_strips + strip).astype(np.float64)
            gathered[i] += counts @ counts
    return _apart(tried, gathered, period, n_answers)


def _apart(
    tried: NDArray[np.float64], gathered: NDArray[np.float64], period: float, n_answers: int
) -> NDArray[np.float64]:
    chosen: list[float] = []
    for index in np.argsort(-gathered, kind="stable"):
        azimuth = float(tried[index])
        if all(abs((azimuth - other + period / 2) % period - period / 2) > APART_RAD for other in chosen):
            chosen.append(azimuth)
        if len(chosen) == n_answers:
            break
    return np.array(chosen)
