"""Axis estimator ``irls``: iteratively reweighted least squares of the paper, eq. 11 to 18."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.bending import bending_m
from tasks.axis.centres import Centres
from tasks.axis.line import (
    Axis,
    effective_number,
    line_distances,
    update_weight_ratio_pct,
)
from tasks.axis.model import AxisEstimator
from tasks.geometry.failure import FitFailure
from tasks.geometry.plane_vectors import small_sample_factor

EPSILON_M2: Final = 1e-6
"""Epsilon of eq. 16, square metres: a scale of 1 mm that is fixed in metres (docs/estimators.md)."""

DELTA: Final = 1e-4
"""Threshold of eq. 17. The paper does not state it; only about 1e-4 gives its printed iteration counts 2, 2, 2, 4
(docs/estimators.md). Converged results need 1e-8 and scatter more (efficiency 0.55 against 0.88)."""

MOST_ITERATIONS: Final = 100
"""k_max of eq. 17."""


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    point_m: NDArray[np.float64]
    direction: NDArray[np.float64]


def fit_irls(
    centres: Centres, delta: float = DELTA, most_iterations: int = MOST_ITERATIONS
) -> Axis | FitFailure:
    """Fit a line in space by the paper's reweighting, to the letter.

    The loop goes back through eq. 13 (the text says 14, which would freeze the centroid whose symbol carries k), and
    the sign of each direction is fixed by up > 0 before eq. 17 compares two of them. ``iterations`` counts the
    directions that were computed, that of equal weights among them: k + 1, at least 2.

    ``lean_covariance`` is that of least squares with equal weights and a variance of one component of
    RMSE^2 m / (2 (m - 2)): eq. 18 divides by m. The weights cannot be taken as given there: they are the residuals
    turned over, and with them the formula doubles the sigma that repeats show. It is widened for few centres by
    ``small_sample_factor``. As it is, it falls 5 to 10 % short without outliers, because the reweighted line scatters
    more than the unweighted one, and is too large with them. With two centres there are no residuals, and the
    covariance is that of the two centres.

    Parameters
    ----------
    centres : Centres
        At least two; their covariances are used for two centres only.
    delta : float
        Threshold of eq. 17 for the change of the unit direction.
    most_iterations : int
        k_max of eq. 17.

    References
    ----------
    Zhou et al. 2025, eq. 11 to 18.
    """
    origin = centres.points_m.mean(axis=0)
    points = centres.points_m - origin
    weights = np.ones(centres.count)
    line = _line_of(points, weights)
    iterations = 1
    while iterations <= most_iterations:
        iterations += 1
        before = line
        weights = 1.0 / (line_distances(points, line.point_m, line.direction) ** 2 + EPSILON_M2)
        line = _line_of(points, weights)
        if float(np.linalg.norm(line.direction - before.direction)) <= delta:
            break
    if line.direction[2] <= 0.0:
        return FitFailure("needs an axis that rises, got a horizontal one")
    residuals = line_distances(points, line.point_m, line.direction)
    two = centres.count == 2
    rmse = float(np.sqrt(np.mean(residuals**2)))
    return Axis(
        point_m=line.point_m + origin,
        direction=line.direction,
        lean_covariance=_two_centre_covariance(centres) if two else _covariance(points[:, 2], rmse),
        weights=weights / weights.max(),
        residuals_m=None if two else residuals,
        iterations=iterations,
        n_effective=effective_number(weights),
        mean_deviation_m=None if two else float(residuals.mean()),
        rmse_m=None if two else rmse,
        bending_m=bending_m(centres, np.ones(centres.count)),
        update_weight_ratio_pct=update_weight_ratio_pct(weights),
        lever_weights=np.ones(centres.count),
    )


def _line_of(points: NDArray[np.float64], weights: NDArray[np.float64]) -> _Line:
    """Weighted centroid (eq. 13), covariance (14) and its first eigenvector (15) with up >= 0."""
    centroid = weights @ points / weights.sum()
    away = points - centroid
    direction = np.linalg.eigh((weights[:, None] * away).T @ away)[1][:, -1]
    return _Line(centroid, direction if direction[2] >= 0.0 else -direction)


def _covariance(z: NDArray[np.float64], rmse: float) -> NDArray[np.float64]:
    """Covariance (2, 2) of the lean of an unweighted line through centres of equal variance."""
    m = len(z)
    variance = rmse**2 * m / (2 * (m - 2))
    wide = small_sample_factor(2 * (m - 2))
    return np.eye(2) * wide * variance / float(np.sum((z - z.mean()) ** 2))


def _two_centre_covariance(centres: Centres) -> NDArray[np.float64]:
    return np.asarray(centres.covariances_m2.sum(axis=0) / centres.span_m**2)


AXIS: Final = AxisEstimator("irls", "reweighting of the paper, 1 / (r^2 + 1e-6 m2)", fit_irls)
