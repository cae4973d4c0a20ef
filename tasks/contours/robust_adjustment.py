"""Bring any shape to the minimum of Tukey's loss, with its scale estimated again and a covariance that says so."""

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle_adjustment import MOST_STEPS, ROUNDING, STEP, Loss, Tukey
from tasks.contours.straightening import StraightSection
from tasks.contours.tukey_circle import CUT, MOST_SCALES, SMALLEST_SCALE
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import mad_sigma

SCALE_STEP: Final = 1e-4
"""The scale counts as settled when it changes by less than this part of itself: weights hardly notice."""

MOST_STRETCH: Final = 1.5
"""Longest that a step of weighted least squares is made: weights understate how fast the influence bends."""

LOOSE_STEP: Final = 0.02
"""Steps below this part of the scale end an iteration whose scale is not the last."""


@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """Residuals (n,) of a shape, metres, and their derivatives (k, n) with respect to its k parameters."""

    residuals_m: NDArray[np.float64]
    jacobian: NDArray[np.float64]


class Shape(Protocol):
    """A closed curve with k parameters, all lengths; the first two are east and north of its centre."""

    @property
    def extent_m(self) -> float:
        """Half of the size of the shape, metres: what steps are compared with."""
        ...

    def at(self, parameters_m: NDArray[np.float64]) -> Linearised | None:
        """Residuals and derivatives at parameters (k,); None where these are no such curve."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Adjusted:
    """Parameters (k,) at a minimum, metres, and the residuals there."""

    parameters_m: NDArray[np.float64]
    at: Linearised


@dataclass(frozen=True, slots=True, eq=False)
class RobustFit:
    """A shape at the minimum of Tukey's loss.

    Attributes
    ----------
    parameters_m : (k,) array
        Parameters of the shape, metres.
    residuals_m : (n,) array
        Residuals of all points, metres.
    used : (n,) bool array
        Points with a weight above zero.
    sigma_m : float
        Robust standard deviation of the residuals, metres.
    variance_m2 : float
        Variance per point that goes with the unweighted normal matrix of the used points, square metres.
    normal : (k, k) array
        That normal matrix, with the prior of the parameters in units of the variance.
    jacobian : (k, n) array
        Derivatives of the residuals.
    """

    parameters_m: NDArray[np.float64]
    residuals_m: NDArray[np.float64]
    used: NDArray[np.bool_]
    sigma_m: float
    variance_m2: float
    normal: NDArray[np.float64]
    jacobian: NDArray[np.float64]

    @property
    def rmse_m(self) -> float:
        """Root mean square residual of the used points, metres."""
        return float(np.sqrt(np.mean(self.residuals_m[self.used] ** 2)))

    def covariance_m2(self) -> NDArray[np.float64]:
        """Covariance (k, k) of the parameters, square metres."""
        return np.asarray(self.variance_m2 * np.linalg.inv(self.normal))


def relative_sigma(sigma_m: NDArray[np.float64] | None, n: int) -> NDArray[np.float64] | FitFailure:
    """Standard deviations (n,) of the points over their median: ones where nothing is known of them."""
    if sigma_m is None:
        return np.ones(n)
    bad = n - int(np.count_nonzero(np.isfinite(sigma_m) & (sigma_m > 0.0)))
    if bad:
        return FitFailure(f"needs a sigma above 0 for every point, got {bad} points without")
    return np.asarray(sigma_m / np.median(sigma_m))


def extent_of(straight: StraightSection) -> float:
    """Largest coordinate of a straightened slice about its mean, metres."""
    return float(np.abs(straight.xy_m).max())


def adjust_shape(
    shape: Shape,
    start_m: NDArray[np.float64],
    loss: Loss,
    penalty: NDArray[np.float64],
    step_limit_m: float | None = None,
) -> Adjusted | FitFailure:
    """Iterate Gauss-Newton steps, damped where the cost would rise, until they are below the limit.

    The cost is the loss of the residuals plus ``penalty`` (k,) times the squared parameters.
    """
    limit = STEP * shape.extent_m if step_limit_m is None else step_limit_m
    parameters, damping = start_m, 0.0
    here = shape.at(parameters)
    if here is None:
        return FitFailure("needs a start that is a closed curve")
    cost = _cost(here, parameters, loss, penalty)
    for _ in range(MOST_STEPS):
        step = _step(here, parameters, loss.weights(here.residuals_m), penalty, damping)
        if step is None:
            return FitFailure("needs an arc that fixes a centre, got a singular system")
        small = float(np.abs(step).max()) <= limit
        there = shape.at(parameters + step)
        if there is not None:
            trial = _cost(there, parameters + step, loss, penalty)
            if trial <= cost * (1 + ROUNDING) or small:
                parameters, here, cost, damping = parameters + step, there, trial, damping / 10
                if small:
                    return Adjusted(parameters, here)
                damping = damping if damping > 1e-6 else 0.0
                continue
        damping = max(10 * damping, 1e-4)
    return FitFailure(f"needs an arc that fixes a contour, got none that converged in {MOST_STEPS} steps")


def settle_shape(
    shape: Shape, start_m: NDArray[np.float64], prior_sd_m: NDArray[np.float64]
) -> RobustFit | FitFailure:
    """Turn scale and shape by turns until the scale stays, then converge; ``prior_sd_m`` (k,) may hold inf.

    The covariance is A / B^2 times the inverse normal matrix of the used points, A the mean squared influence with
    n - k degrees of freedom, B the mean slope of the influence.

    References
    ----------
    Huber 1981, Robust Statistics, section 7.6.
    """
    here = shape.at(start_m)
    if here is None:
        return FitFailure("needs a start that is a closed curve")
    at, sigma = Adjusted(start_m, here), _scale(shape, here, len(start_m))
    for _ in range(MOST_SCALES):
        penalty = (sigma / prior_sd_m) ** 2
        loose = adjust_shape(shape, at.parameters_m, Tukey(CUT * sigma), penalty, LOOSE_STEP * sigma)
        if isinstance(loose, FitFailure):
            return loose
        before, at, sigma = sigma, loose, _scale(shape, loose.at, len(start_m))
        if abs(sigma - before) <= SCALE_STEP * before:
            break
    final = adjust_shape(shape, at.parameters_m, Tukey(CUT * sigma), (sigma / prior_sd_m) ** 2)
    return final if isinstance(final, FitFailure) else _with_scatter(final, sigma, prior_sd_m)


def _scale(shape: Shape, at: Linearised, parameters: int) -> float:
    """Scale from the median absolute residual, freed of what the parameters absorb, metres."""
    n = len(at.residuals_m)
    freed = float(np.sqrt(n / (n - parameters)))
    return max(mad_sigma(at.residuals_m) * freed, SMALLEST_SCALE * shape.extent_m)


def _cost(at: Linearised, parameters: NDArray[np.float64], loss: Loss, penalty: NDArray[np.float64]) -> float:
    return loss.cost(at.residuals_m) + float(penalty @ parameters**2)


def _step(
    at: Linearised,
    parameters: NDArray[np.float64],
    weights: NDArray[np.float64],
    penalty: NDArray[np.float64],
    damping: float,
) -> NDArray[np.float64] | None:
    """Levenberg-Marquardt step (k,), or None where the normal matrix is singular."""
    weighted = at.jacobian * weights
    normal = weighted @ at.jacobian.T
    diagonal = np.diag_indices(len(normal))
    normal[diagonal] = normal[diagonal] * (1.0 + damping) + penalty
    try:
        step = np.linalg.solve(normal, -(weighted @ at.residuals_m + penalty * parameters))
    except np.linalg.LinAlgError:
        return None
    stretch = 1.0 if damping > 0.0 else _stretch(weights)
    return np.asarray(stretch * step, dtype=np.float64) if np.isfinite(step).all() else None


def _stretch(weights: NDArray[np.float64]) -> float:
    """Newton's step over that of weighted least squares, from the mean slope of the influence.

    The slope is (1 - u)(1 - 5 u) where the weight is (1 - u)^2, and 1 where it is 1. It saves half of the steps.
    """
    mean = float(weights.mean())
    slope = 5.0 * mean - 4.0 * float(np.sqrt(weights).mean())
    return min(mean / slope, MOST_STRETCH) if slope > 0.0 else 1.0


def _with_scatter(final: Adjusted, sigma_m: float, prior_sd_m: NDArray[np.float64]) -> RobustFit | FitFailure:
    residuals, jacobian = final.at.residuals_m, final.at.jacobian
    ratio = np.minimum((residuals / (CUT * sigma_m)) ** 2, 1.0)
    used = ratio < 1.0
    n, k = int(used.sum()), len(jacobian)
    if n <= k or 2 * n < len(residuals):
        return FitFailure(f"needs most points on one contour, got {n} of {len(residuals)}")
    influence = float(np.sum(((1.0 - ratio) ** 2 * residuals) ** 2)) / (n - k)
    slope = float(np.mean((1.0 - ratio[used]) * (1.0 - 5.0 * ratio[used])))
    if slope <= 0.0:
        return FitFailure("needs residuals that gather about a contour, got ones that spread evenly")
    variance = influence / slope**2
    normal = (jacobian * used) @ jacobian.T + np.diag(variance / prior_sd_m**2)
    if np.linalg.cond(normal) > 1 / np.finfo(float).eps:
        return FitFailure("arc too short for a centre: the points fix no contour")
    return RobustFit(final.parameters_m, residuals, used, sigma_m, variance, normal, jacobian)
