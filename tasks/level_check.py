"""Does every station see the shaft as plumb as the others do: finds a scanner out of level, which nothing else sees.

A scan-to-scan adjustment hardly notices a wrong level, because the level itself is held. But the half shaft of a station
that is out of level leans against the common one, by its own error, and that shows in arc seconds.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import MAD_TO_SIGMA, tukey_weights
from tasks.preprocessing import ShaftModel

LEAST_POINTS: Final = 500
"""Fewer points of a station on the shaft tell nothing of its level."""

REWEIGHTINGS: Final = 4

SUSPECT_CHI2: Final = 20.0
"""Chi-square of 2 degrees of freedom that chance reaches in one of 20,000 stations. Simulated stations within their
stated level stayed below 6, one 20 seconds out reached 33, one 60 seconds out 295."""


@dataclass(frozen=True, slots=True)
class LevelCheck:
    """How much a station's half shaft leans against the common one, and how unlikely that is.

    ``lean_east`` and ``lean_north`` are dimensionless; ``chi2`` has 2 degrees of freedom and covers the noise of the
    points and the stated level. All are None for a station with too few points on the shaft.
    """

    lean_east: float | None
    lean_north: float | None
    chi2: float | None


NOT_CHECKED: Final = LevelCheck(None, None, None)


def check_levels(
    points_m: NDArray[np.float64],
    station_index: NDArray[np.uint16],
    model: ShaftModel,
    level_sigmas_rad: Sequence[float],
) -> tuple[LevelCheck, ...]:
    """Check the stations of an epoch against the shaft that all of them see.

    Parameters
    ----------
    points_m : (n, 3) array
        Points of the isolated shaft, site frame, metres.
    station_index : (n,) array
        Which station saw each.
    model : ShaftModel
        The common shaft.
    level_sigmas_rad : sequence of float
        Standard deviation of one component of the level, a station each.
    """
    n = len(level_sigmas_rad)
    if n < 2:
        return (NOT_CHECKED,) * n
    # the common shaft follows each station by its share: what is left of its own level is smaller
    own = np.sqrt((n - 1) / n)
    return tuple(
        _check_one(points_m[station_index == i], model, own * sigma)
        for i, sigma in enumerate(level_sigmas_rad)
    )


def worst_suspect(checks: Sequence[LevelCheck]) -> int | None:
    """Index of the station that is most out of level, if any is.

    One only: a bad station moves the common shaft, and the others then look worse than they are.
    """
    chi2 = [check.chi2 if check.chi2 is not None else 0.0 for check in checks]
    worst = int(np.argmax(chi2)) if chi2 else 0
    return worst if chi2 and chi2[worst] > SUSPECT_CHI2 else None


def _check_one(points_m: NDArray[np.float64], model: ShaftModel, level_sigma_rad: float) -> LevelCheck:
    if len(points_m) < LEAST_POINTS:
        return NOT_CHECKED
    z = points_m[:, 2]
    away = points_m[:, :2] - model.axis_at(z)
    distance = np.hypot(*away.T)
    outward = away / distance[:, None]
    residual = distance - model.radius_at(z)
    height = z - z.mean()
    # shift and lean of the half shaft against the common one, and what the radius is off
    design = np.column_stack([outward, outward * height[:, None], np.ones(len(z))])
    solution, covariance = _robust_fit(design, residual)
    lean = solution[2:4]
    spread = covariance[2:4, 2:4] + level_sigma_rad**2 * np.eye(2)
    return LevelCheck(float(lean[0]), float(lean[1]), float(lean @ np.linalg.solve(spread, lean)))


def _robust_fit(
    design: NDArray[np.float64], residual: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients (p,) by Tukey's weights, and their covariance (p, p) from the scatter."""
    error = residual - np.median(residual)
    for _ in range(REWEIGHTINGS):
        sigma = max(float(MAD_TO_SIGMA * np.median(np.abs(error))), 1e-9)
        weight = tukey_weights(error, sigma)
        normal = design.T @ (design * weight[:, None])
        solution = np.linalg.solve(normal, design.T @ (weight * residual))
        error = residual - design @ solution
    return np.asarray(solution), np.asarray(np.linalg.inv(normal) * sigma**2)
