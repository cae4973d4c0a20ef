"""The compiled loops of circle fits do what plain arithmetic does."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.contours.circle_kernel import nearest_circle, sum_circle, sum_used

Ring = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]

CIRCLE = (0.02, -0.03, 3.9)


def points(n: int = 1500) -> Ring:
    """East, north, widening and relative sigma (n,) of a noisy ring with strays; more than one block of them."""
    rng = np.random.default_rng(6)
    turn = rng.uniform(-np.pi, np.pi, n)
    widening = 0.01 * rng.standard_normal(n)
    distance = 3.9 + widening + 0.01 * rng.standard_normal(n) + np.where(np.arange(n) % 7 == 0, 0.2, 0.0)
    return distance * np.cos(turn), distance * np.sin(turn), widening, rng.uniform(0.5, 2.0, n)


def plain(ring: Ring, sigma: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Residuals (n,) over sigma, and the Jacobian (n, 3) over sigma."""
    x, y, widening, _ = ring
    away = np.column_stack([CIRCLE[0] - x, CIRCLE[1] - y])
    distance = np.linalg.norm(away, axis=1)
    jacobian = np.column_stack([away / distance[:, None], -np.ones(len(x))])
    return (distance - widening - CIRCLE[2]) / sigma, jacobian / sigma[:, None]


def assert_sums(found: NDArray[np.float64], normal: NDArray[np.float64], right: NDArray[np.float64]) -> None:
    assert found[:6] == pytest.approx(normal[np.triu_indices(3)], rel=1e-12, abs=1e-9)
    assert found[6:9] == pytest.approx(right, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("is_weighted", [False, True])
@pytest.mark.parametrize("cut_m", [0.06, np.inf])
def test_normal_equations_and_cost_are_those_of_plain_arithmetic(cut_m: float, is_weighted: bool) -> None:
    ring = points()
    x, y, widening, sigma = ring
    relative = sigma if is_weighted else np.ones(len(x))
    found = sum_circle((x, y, widening, sigma if is_weighted else np.empty(0)), CIRCLE, cut_m)
    residual, jacobian = plain(ring, relative)
    inside = 1.0 - np.minimum((residual / cut_m) ** 2, 1.0)
    weighted = jacobian * (inside**2)[:, None]
    assert_sums(found, weighted.T @ jacobian, weighted.T @ residual)
    cost = residual @ residual if cut_m == np.inf else cut_m**2 / 3.0 * np.sum(1.0 - inside**3)
    assert found[9] == pytest.approx(cost, rel=1e-12)


def test_points_that_are_not_used_do_not_count() -> None:
    ring = points()
    used = np.arange(len(ring[0])) % 3 != 0
    residual, jacobian = plain(ring, ring[3])
    found = sum_used(ring, CIRCLE, used)
    assert_sums(found, jacobian[used].T @ jacobian[used], jacobian[used].T @ residual[used])


@pytest.mark.parametrize("n", [179, 180])
def test_the_nearest_circle_is_the_one_with_the_least_median(n: int) -> None:
    x, y, widening, _ = points(n)
    centers = 0.05 * np.random.default_rng(8).standard_normal((n, 2))
    distance = np.hypot(x - centers[:, :1], y - centers[:, 1:]) - widening
    radii = np.median(distance, axis=1)
    best = int(np.argmin(np.median(np.abs(distance - radii[:, None]), axis=1)))
    found = nearest_circle((x, y, widening, np.empty(0)), centers)
    assert found == pytest.approx((*centers[best], radii[best]), rel=1e-14)
