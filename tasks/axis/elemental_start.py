"""High-breakdown start of a line: the pair of centres with the least median of distances, then an S estimate."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.adjustment import solve_weighted
from tasks.axis.height_fit import Settled, has_settled
from tasks.axis.loss import TUKEY_S, bounded_loss
from tasks.axis.observations import Observations

MOST_PAIRS: Final = 1000
"""Lines that are tried: with half of the centres bad a quarter of them join two good ones."""

LEAST_PART: Final = 0.2
"""A pair nearer to each other than this part of the height range says little of the lean."""

BEST_PAIRS: Final = 3
"""Starts that are refined."""

FIRST_STEPS: Final = 5
"""Refinements of every start before the best of them goes on."""

MOST_STEPS: Final = 20
"""Refinements of the best; what is left of its change does not matter, the weights are settled by another cut."""


def estimate_s(observations: Observations) -> Settled:
    """Estimate a straight line with the least robust scale: it holds while more than half of the centres are good.

    Starts are lines through two centres. References: Rousseeuw & Yohai 1984, Robust regression by means of S-estimators;
    Salibian-Barrera & Yohai 2006, A fast algorithm for S-regression.
    """
    refined = [_refine(observations, start, FIRST_STEPS) for start in _best_pairs(observations)]
    best = min(refined, key=lambda settled: _scale_and_loss(observations, settled))
    return _refine(observations, best.coefficients_m, MOST_STEPS)


def _best_pairs(observations: Observations) -> NDArray[np.float64]:
    """Coefficients (k, 2, 2) of the lines through two centres with the least medians of distances."""
    x = observations.basis[:, 1]
    ranked = np.argsort(x, kind="stable")
    low, high = np.triu_indices(len(x), 1)
    far = x[ranked[high]] - x[ranked[low]] >= 2.0 * LEAST_PART
    step = -(-int(far.sum()) // MOST_PAIRS)
    low, high = ranked[low[far][::step]], ranked[high[far][::step]]
    slopes = (observations.horizontal_m[high] - observations.horizontal_m[low]) / (x[high] - x[low])[:, None]
    lines = np.stack([observations.horizontal_m[low] - slopes * x[low, None], slopes], axis=1)
    squares = sum(
        (observations.horizontal_m[:, a] - lines[:, 0, a, None] - lines[:, 1, a, None] * x) ** 2
        for a in (0, 1)
    )
    place = (len(x) + 1) // 2
    medians = np.partition(squares, place, axis=1)[:, place]
    return np.asarray(lines[np.argsort(medians, kind="stable")[:BEST_PAIRS]])


def _refine(observations: Observations, start_m: NDArray[np.float64], steps: int) -> Settled:
    coefficients = start_m
    for _ in range(steps):
        residuals = observations.residuals(coefficients)
        variance = observations.s_model_variance(residuals, bounded_loss, observations.freedom / 2.0)
        weights = TUKEY_S.weights(np.sqrt(observations.squared_lengths(residuals, variance)))
        before = coefficients
        coefficients = solve_weighted(observations, weights, variance)
        if has_settled(observations, before, coefficients, variance):
            break
    return Settled(coefficients, weights, variance, steps)


def _scale_and_loss(observations: Observations, settled: Settled) -> tuple[float, float]:
    """The model error, and the mean loss where the points alone explain the scatter."""
    residuals = observations.residuals(settled.coefficients_m)
    lengths = observations.squared_lengths(residuals, settled.variance_m2)
    return settled.variance_m2, float(np.mean(bounded_loss(lengths)))
