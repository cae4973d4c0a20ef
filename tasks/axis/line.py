"""The axis that was fitted, and what follows from a line and its centres."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

MOST_TILT_DEG: Final = 60.0
"""A steeper lean is no standing shaft but centres that follow something else, degrees."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisCurve:
    """The form of an axis that may bend.

    Attributes
    ----------
    model : str
        straight, parabola, cubic, spline, ...
    reason : str
        Why that form was chosen: the test and its outcome.
    z_m : (k,) array
        Heights, ascending, at which the curve is stated, metres.
    east_m, north_m : (k,) arrays
        The curve there, site frame, metres.
    base_lean, chord_lean : (2,) arrays
        Lean vector of the tangent at the lowest height, and of the line from the lowest to the highest point.
    base_lean_sigma : float or None
        Standard deviation of one component of ``base_lean`` from the centres and their points alone.
    """

    model: str
    reason: str
    z_m: NDArray[np.float64]
    east_m: NDArray[np.float64]
    north_m: NDArray[np.float64]
    base_lean: NDArray[np.float64]
    chord_lean: NDArray[np.float64]
    base_lean_sigma: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """A straight axis.

    Attributes
    ----------
    point_m : (3,) array
        A point of the axis amid the centres, site frame, metres.
    direction : (3,) array
        Unit direction (east, north, up) with up > 0.
    lean_covariance : (2, 2) array
        Covariance of the lean vector (d_e/d_u, d_n/d_u), from the centres and their points alone.
    weights : (m,) array
        Weight of each centre in the axis, the largest is 1.
    residuals_m : (m,) array or None
        Shortest distances of the centres from the axis, metres; None where two centres leave nothing over.
    iterations : int or None
        Directions that were computed one after the other; None for a direct line.
    n_effective : float or None
        (sum w)^2 / sum w^2; None for a direct line.
    mean_deviation_m, rmse_m : float or None
        Eq. 18, unweighted, divisor m, metres; None where there are no residuals.
    bending_m : float or None
        Largest distance of a parabola through the centres from its own straight line within their height range,
        metres; None for fewer than 4 centres.
    update_weight_ratio_pct : float or None
        Share of the centres whose final weight is below half of the largest, percent: our definition, the paper
        defines none; None for a direct line.
    curve : AxisCurve or None
        The form of the axis; None for estimators that know only a line.
    warning : str or None
        What to mind before signing.
    lever_weights : (m,) array or None
        Weights with which the lean follows small shifts of the centres, where they are not ``weights``: a weight that is
        a residual turned over says nothing of it.
    """

    point_m: NDArray[np.float64]
    direction: NDArray[np.float64]
    lean_covariance: NDArray[np.float64]
    weights: NDArray[np.float64]
    residuals_m: NDArray[np.float64] | None
    iterations: int | None
    n_effective: float | None
    mean_deviation_m: float | None
    rmse_m: float | None
    bending_m: float | None
    update_weight_ratio_pct: float | None
    curve: AxisCurve | None = None
    warning: str | None = None
    lever_weights: NDArray[np.float64] | None = None

    @property
    def levers(self) -> NDArray[np.float64]:
        """Weights (m,) with which the lean follows small shifts of the centres."""
        return self.weights if self.lever_weights is None else self.lever_weights

    @property
    def lean(self) -> NDArray[np.float64]:
        """Lean vector (2,): d_e/d_u, d_n/d_u."""
        return np.asarray(self.direction[:2] / self.direction[2])

    @property
    def tilt_deg(self) -> float:
        """Angle between the axis and the vertical, degrees."""
        return float(np.degrees(np.arctan2(np.hypot(*self.direction[:2]), self.direction[2])))


def direction_of_lean(lean: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit direction (3,) of a lean vector (2,), up > 0."""
    direction = np.array([lean[0], lean[1], 1.0])
    return np.asarray(direction / np.linalg.norm(direction))


def line_distances(
    points_m: NDArray[np.float64], point_m: NDArray[np.float64], direction: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Shortest distances (m,) of points (m, 3) from a line through a point along a unit direction (eq. 16), metres."""
    away = points_m - point_m
    return np.asarray(np.linalg.norm(away - np.outer(away @ direction, direction), axis=1))


def effective_number(weights: NDArray[np.float64]) -> float:
    """Kish's effective number of weighted centres (m,): (sum w)^2 / sum w^2."""
    return float(weights.sum() ** 2 / np.sum(weights**2))


def update_weight_ratio_pct(weights: NDArray[np.float64]) -> float:
    """Share of weights (m,) below half of the largest, percent: our own reading of the paper's term."""
    return 100.0 * float(np.mean(weights < 0.5 * weights.max()))
