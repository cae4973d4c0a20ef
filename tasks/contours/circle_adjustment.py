"""Bring a circle to the minimum of a sum over orthogonal distances."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle
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


@dataclass(frozen=True, slots=True, eq=False)
class CircleLoss:
    """Tukey's biweight with a fixed cut, metres, or least squares where it is infinite.

    ``relative_sigma`` (n,) divides the residuals of the points; None where all are alike.
    """

    cut_m: float
    relative_sigma: NDArray[np.float64] | None = None


LEAST_SQUARES: Final = CircleLoss(np.inf)


@dataclass(frozen=True, slots=True, eq=False)
class _Sums:
    """Normal matrix (3, 3) of a circle before damping, right side (3,) and cost."""

    normal: NDArray[np.float64]
    right: NDArray[np.float64]
    cost: float


def used_normal(
    section: StraightSection,
    circle: Circle,
    used: NDArray[np.bool_],
    relative_sigma: NDArray[np.float64] | None,
) -> NDArray[np.float64]:
    """Normal matrix (3, 3) of the points that are used (n,) with respect to east, north and radius of a circle."""
    from tasks.contours.circle_kernel import sum_used  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    place = (circle.east_m, circle.north_m, circle.radius_m)
    return _sums(sum_used(_points(section, relative_sigma), place, used)).normal


def adjust_circle(
    section: StraightSection, start: Circle, loss: CircleLoss, step_limit: float = STEP
) -> Circle | FitFailure:
    """Iterate Gauss-Newton steps, damped where the cost would rise, until they are below ``step_limit`` radii."""
    extent = float(np.abs(section.xy_m).max())
    circle, damping = start, 0.0
    look = _look(section, loss)
    here = look(circle)
    for _ in range(MOST_STEPS):
        step = _damped_step(here, damping)
        if step is None:
            return FitFailure("needs an arc that fixes a centre, got a singular system")
        trial = _moved(circle, step)
        small = float(np.abs(step).max()) <= step_limit * circle.radius_m
        if trial.finite:
            there = look(trial)
            if there.cost <= here.cost * (1 + ROUNDING) or small:
                circle, here, damping = trial, there, damping / 10
                if small:
                    return circle
                if circle.radius_m > WIDEST * extent:
                    return FitFailure("needs an arc that fixes a centre, got points on one line")
                damping = damping if damping > 1e-6 else 0.0
                continue
        damping = max(10 * damping, 1e-4)
    return FitFailure(f"circle did not converge in {MOST_STEPS} steps")


def _look(section: StraightSection, loss: CircleLoss) -> Callable[[Circle], _Sums]:
    """What says how the points lie on a circle: one loop over them."""
    from tasks.contours.circle_kernel import sum_circle  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    points = _points(section, loss.relative_sigma)

    def at(circle: Circle) -> _Sums:
        return _sums(sum_circle(points, (circle.east_m, circle.north_m, circle.radius_m), loss.cut_m))

    return at


def _points(
    section: StraightSection, relative_sigma: NDArray[np.float64] | None
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """East, north, widening and relative sigma of the points of a slice, each in one run of memory."""
    sigma = np.empty(0) if relative_sigma is None else np.ascontiguousarray(relative_sigma)
    east, north = (np.ascontiguousarray(column) for column in section.xy_m.T)
    return east, north, np.ascontiguousarray(section.widening_m), sigma


def _sums(found: NDArray[np.float64]) -> _Sums:
    ee, en, er, nn, nr, rr, *right = found[:9].tolist()
    return _Sums(np.array([[ee, en, er], [en, nn, nr], [er, nr, rr]]), np.array(right), float(found[9]))


def _moved(circle: Circle, step: NDArray[np.float64]) -> Circle:
    return Circle(
        circle.east_m + float(step[0]), circle.north_m + float(step[1]), circle.radius_m + float(step[2])
    )


def _damped_step(at: _Sums, damping: float) -> NDArray[np.float64] | None:
    """Levenberg-Marquardt step (3,), or None where the normal matrix is singular."""
    normal = at.normal.copy()
    normal[np.diag_indices(3)] *= 1.0 + damping
    try:
        step: NDArray[np.float64] = np.linalg.solve(normal, -at.right).astype(np.float64)
    except np.linalg.LinAlgError:
        return None
    return step if np.isfinite(step).all() else None
