"""Bring a circle to the minimum of a sum over orthogonal distances."""

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle, center_distances
from tasks.contours.straightening import StraightSection
from tasks.geometry.failure import FitFailure

STEP: Final = 1e-10
"""A step below this part of the radius ends the iteration: 0.4 nm on a shaft of 4 m."""

ROUNDING: Final = 1e-12
"""A cost that rises by less than this part of itself has not risen: sums of float64 are no better."""

MOST_STEPS: Final = 200
"""Steps before a fit counts as not converged; good data need about 10."""

WIDEST: Final = 1e4
"""A radius beyond this many times the extent of the points is a straight line."""


class Loss(Protocol):
    """What a residual costs, and the weight that belongs to it."""

    def cost(self, residuals_m: NDArray[np.float64]) -> float:
        """Total cost of residuals (n,)."""
        ...

    def weights(self, residuals_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weights (n,) whose least squares has the same minimum."""
        ...


@dataclass(frozen=True, slots=True)
class Squares:
    """Least squares: every point with weight one."""

    def cost(self, residuals_m: NDArray[np.float64]) -> float:
        """Sum of squares."""
        return float(residuals_m @ residuals_m)

    def weights(self, residuals_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Ones."""
        return np.ones_like(residuals_m)


@dataclass(frozen=True, slots=True)
class Tukey:
    """Tukey's biweight with a fixed cut, metres."""

    cut_m: float

    def cost(self, residuals_m: NDArray[np.float64]) -> float:
        """Sum of rho, scaled so that it is the sum of squares for small residuals."""
        inside = 1.0 - np.minimum((residuals_m / self.cut_m) ** 2, 1.0)
        return self.cut_m**2 / 3 * float(np.sum(1.0 - inside * inside * inside))

    def weights(self, residuals_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Biweight, 1 at zero and 0 beyond the cut."""
        return np.asarray((1.0 - np.minimum((residuals_m / self.cut_m) ** 2, 1.0)) ** 2)


def circle_jacobian(section: StraightSection, circle: Circle) -> NDArray[np.float64]:
    """Derivatives (n, 3) of the residuals with respect to east, north and radius."""
    # at the centre itself no direction is better than another: 0 / tiny leaves the point without a say
    length = np.maximum(center_distances(section.xy_m, circle), np.finfo(float).tiny)
    jacobian = np.full((3, len(length)), -1.0)
    jacobian[0] = (circle.east_m - section.xy_m[:, 0]) / length
    jacobian[1] = (circle.north_m - section.xy_m[:, 1]) / length
    return jacobian.T


def adjust_circle(
    section: StraightSection, start: Circle, loss: Loss, step_limit: float = STEP
) -> Circle | FitFailure:
    """Iterate Gauss-Newton steps, damped where the cost would rise, until they are below ``step_limit`` radii."""
    extent = float(np.abs(section.xy_m).max())
    circle, damping = start, 0.0
    residuals = section.residuals(circle)
    cost = loss.cost(residuals)
    for _ in range(MOST_STEPS):
        step = _damped_step(section, circle, residuals, loss.weights(residuals), damping)
        if step is None:
            return FitFailure("needs an arc that fixes a centre, got a singular system")
        trial = _moved(circle, step)
        small = float(np.abs(step).max()) <= step_limit * circle.radius_m
        if trial.finite:
            trial_residuals = section.residuals(trial)
            trial_cost = loss.cost(trial_residuals)
            if trial_cost <= cost * (1 + ROUNDING) or small:
                circle, residuals, cost, damping = trial, trial_residuals, trial_cost, damping / 10
                if small:
                    return circle
                if circle.radius_m > WIDEST * extent:
                    return FitFailure("needs an arc that fixes a centre, got points on one line")
                damping = damping if damping > 1e-6 else 0.0
                continue
        damping = max(10 * damping, 1e-4)
    return FitFailure(f"circle did not converge in {MOST_STEPS} steps")


def _moved(circle: Circle, step: NDArray[np.float64]) -> Circle:
    return Circle(
        circle.east_m + float(step[0]), circle.north_m + float(step[1]), circle.radius_m + float(step[2])
    )


def _damped_step(
    section: StraightSection,
    circle: Circle,
    residuals: NDArray[np.float64],
    weights: NDArray[np.float64],
    damping: float,
) -> NDArray[np.float64] | None:
    """Levenberg-Marquardt step (3,), or None where the normal matrix is singular."""
    jacobian = circle_jacobian(section, circle)
    weighted = jacobian.T * weights
    normal = weighted @ jacobian
    normal[np.diag_indices(3)] *= 1.0 + damping
    try:
        step: NDArray[np.float64] = np.linalg.solve(normal, -(weighted @ residuals)).astype(np.float64)
    except np.linalg.LinAlgError:
        return None
    return step if np.isfinite(step).all() else None
