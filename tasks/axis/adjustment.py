"""Weighted least squares of the centres with a model error, and its start."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.axis.observations import Observations, median

MEDIAN_REGRESSION_STEPS: Final = 30
"""Reweightings of the start, which need not be exact."""


def normal_matrix(
    observations: Observations, weights: NDArray[np.float64], variance_m2: float
) -> NDArray[np.float64]:
    """Normal matrix (2p, 2p) of weights (m,) and a model error, the coefficients of east before those of north."""
    information = observations.information(variance_m2) * weights[:, None, None]
    return _normal(observations.basis, information)


def solve_weighted(
    observations: Observations, weights: NDArray[np.float64], variance_m2: float
) -> NDArray[np.float64]:
    """Coefficients (p, 2) of weighted least squares."""
    p = observations.basis.shape[1]
    information = observations.information(variance_m2) * weights[:, None, None]
    pulled = (information @ observations.horizontal_m[:, :, None])[:, :, 0]
    right = (pulled.T @ observations.basis).reshape(2 * p)
    solution = np.linalg.solve(_normal(observations.basis, information), right)
    return np.asarray(solution.reshape(2, p).T, dtype=np.float64)


def median_regression(observations: Observations) -> NDArray[np.float64]:
    """Coefficients (p, 2) with the least sum of distances, whatever the stated covariances say of the centres."""
    basis, horizontal = observations.basis, observations.horizontal_m
    weights = np.ones(len(basis))
    for _ in range(MEDIAN_REGRESSION_STEPS):
        weighted = basis.T * weights
        coefficients = np.asarray(np.linalg.solve(weighted @ basis, weighted @ horizontal), dtype=np.float64)
        residuals = observations.residuals(coefficients)
        distances = np.sqrt(residuals[:, 0] ** 2 + residuals[:, 1] ** 2)
        floor = 1e-3 * median(distances)
        if floor == 0.0:
            break
        weights = 1.0 / np.maximum(distances, floor)
        weights = weights / weights.max()
    return coefficients


def _normal(basis: NDArray[np.float64], information: NDArray[np.float64]) -> NDArray[np.float64]:
    m, p = basis.shape
    products = (basis[:, :, None] * basis[:, None, :]).reshape(m, p * p)
    blocks = information.reshape(m, 4).T @ products
    return np.asarray(blocks.reshape(2, 2, p, p).transpose(0, 2, 1, 3).reshape(2 * p, 2 * p))
