import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.uncertainty import bootstrap_slices, leverage

HEIGHTS_M = np.linspace(2.0, 102.0, 51)
SIGMA_M = 0.004
WEIGHTS = np.where(np.arange(51) % 3 == 0, 0.25, 1.0)
"""Every third centre has twice the standard deviation."""


def centres(rng: np.random.Generator, outlier_m: float = 0.0) -> NDArray[np.float64]:
    """Centres (51, 3) of a leaning shaft with independent errors as large as the weights say."""
    off = SIGMA_M / np.sqrt(WEIGHTS)[:, None] * rng.standard_normal((51, 2))
    off[40] += outlier_m
    return np.column_stack([np.outer(HEIGHTS_M, [0.007, -0.0057]) + off, HEIGHTS_M])


def exact() -> float:
    """Variance of one component of the lean by least squares."""
    levers = leverage(HEIGHTS_M, WEIGHTS)
    return float(np.sum(levers**2 * SIGMA_M**2 / WEIGHTS))


def test_independent_slices_give_the_covariance_of_least_squares() -> None:
    rng = np.random.default_rng(1)
    found = np.array([bootstrap_slices(centres(rng), WEIGHTS) for _ in range(40)])
    # 49 degrees of freedom, two components, 40 draws: 2 %, and as much of 400 resamples
    assert np.trace(found.mean(axis=0)) / 2.0 == pytest.approx(exact(), rel=0.1)
    assert abs(found.mean(axis=0)[0, 1]) < 0.1 * exact()


def test_an_error_that_nobody_stated_shows() -> None:
    found = bootstrap_slices(centres(np.random.default_rng(2), outlier_m=0.05), WEIGHTS)
    assert found is not None
    assert np.trace(found) / 2.0 > 1.5 * exact()


def test_the_same_centres_give_the_same_covariance() -> None:
    once, again = (bootstrap_slices(centres(np.random.default_rng(3)), WEIGHTS) for _ in range(2))
    assert once is not None
    assert (once == again).all()


def test_a_lean_adds_no_uncertainty() -> None:
    plumb = centres(np.random.default_rng(4))
    leaning = plumb.copy()
    leaning[:, :2] += np.outer(HEIGHTS_M, [0.05, 0.02])
    assert bootstrap_slices(leaning, WEIGHTS) == pytest.approx(
        np.array(bootstrap_slices(plumb, WEIGHTS)), rel=1e-6
    )


def test_fewer_than_eight_centres_with_a_weight_are_too_few() -> None:
    weights = np.zeros(51)
    weights[:7] = 1.0
    assert bootstrap_slices(centres(np.random.default_rng(5)), weights) is None
    weights[7] = 1.0
    assert bootstrap_slices(centres(np.random.default_rng(5)), weights) is not None
