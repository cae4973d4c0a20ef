"""A linear model of two components whose noise is that of the epochs and a random walk, taken apart once for all sigmas.

The observations are whitened by the covariances of the epochs and turned so that the random walk is diagonal in what the
unknowns leave over. Then estimate, covariance and likelihood for any sigma of the walk cost a few products: the trend, the
average over the sigma that is not known, and thousands of simulated series all use it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.trend.series import LeanSeries

COARSE_NODES: Final = 192
FINE_NODES: Final = 24
DROP: Final = 10.0
"""Log-likelihood below its maximum from which on a sigma does not count: exp(-10)."""

Likelihood = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Restricted log-likelihood (g,) of sigmas (g,), up to a constant."""


@dataclass(frozen=True, slots=True)
class Rotated:
    """Observations in the basis of a model: ``fitted`` (2p, ...) that the unknowns take up, ``left`` (m, ...) over."""

    fitted: NDArray[np.float64]
    left: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Estimate:
    """Unknowns under one sigma of the walk.

    ``values`` (2p, ...): of the columns in order, east and north of each; ``covariance`` (2p, 2p).
    """

    values: NDArray[np.float64]
    covariance: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class WalkSigma:
    """What the observations tell of the walk's sigma, metres per square root of a year.

    ``nodes`` and ``weights`` (g,): the REML likelihood as a density of sigma (every sigma equally likely before);
    ``reml`` its maximum, None where the model has no walk.
    """

    nodes: NDArray[np.float64]
    weights: NDArray[np.float64]
    reml: float | None


@dataclass(frozen=True, slots=True)
class WalkModel:
    """See the module. ``spectrum`` (m,) are the variances of ``Rotated.left`` that a walk of sigma 1 adds to 1."""

    span: float
    random_walk: bool
    spectrum: NDArray[np.float64]
    factors: NDArray[np.float64]
    solver: NDArray[np.float64]
    fitted_basis: NDArray[np.float64]
    left_basis: NDArray[np.float64]
    walk_fitted: NDArray[np.float64]
    walk_across: NDArray[np.float64]

    @property
    def n_unknowns(self) -> int:
        """Unknowns of both components, 2p."""
        return len(self.solver)


def build_model(series: LeanSeries, columns: NDArray[np.float64], random_walk: bool) -> WalkModel:
    """Take the model of a series apart.

    Parameters
    ----------
    series : LeanSeries
        Its times and covariances; the movements are not used.
    columns : (n, p) array
        Of one component; both have the same.
    random_walk : bool
        Whether there is one besides the noise of the epochs. It starts at the first epoch and its components are alike
        and independent: covariance sigma^2 min(t_i - t_0, t_j - t_0).

    Raises
    ------
    ShapeError
        If the columns are not (n, p), depend on each other, or leave nothing over.
    """
    from scipy import linalg  # noqa: PLC0415 (slow to import)

    n, unknowns = series.n_epochs, 2 * columns.shape[1]
    if columns.shape[0] != n or unknowns >= 2 * n:
        raise ShapeError(f"build_model needs columns (n, p) with p < n = {n}; got {columns.shape}")
    factors = np.asarray(np.linalg.cholesky(series.covariances), dtype=np.float64)
    Q, R = linalg.qr(_whitened(factors, twofold(columns)))
    diagonal = np.abs(np.diag(R))
    if diagonal.min() <= 1e-10 * diagonal.max():
        raise ShapeError("build_model needs columns that do not depend on each other")
    elapsed = series.times - series.times[0]
    walk = float(random_walk) * twofold(np.minimum.outer(elapsed, elapsed))
    K = _whitened(factors, _whitened(factors, walk).T)
    spectrum, turn = linalg.eigh(Q[:, unknowns:].T @ K @ Q[:, unknowns:])
    left = Q[:, unknowns:] @ turn
    return WalkModel(
        span=series.span,
        random_walk=random_walk,
        spectrum=np.clip(spectrum, 0.0, None),
        factors=factors,
        solver=linalg.solve_triangular(R[:unknowns], np.eye(unknowns)),
        fitted_basis=Q[:, :unknowns],
        left_basis=left,
        walk_fitted=Q[:, :unknowns].T @ K @ Q[:, :unknowns],
        walk_across=Q[:, :unknowns].T @ K @ left,
    )


def rotate(model: WalkModel, observed: NDArray[np.float64]) -> Rotated:
    """Turn observations (2n, ...), east and north of each epoch in turn, into the basis of the model."""
    white = _whitened(model.factors, observed)
    return Rotated(model.fitted_basis.T @ white, model.left_basis.T @ white)


def estimate(model: WalkModel, rotated: Rotated, sigma: float) -> Estimate:
    """Best linear unbiased estimate under a sigma of the walk; several columns of observations at once.

    The generalised least squares estimate is what ordinary least squares of the whitened observations gives, less the
    part of the walk in it that the rest of the observations tells of.
    """
    s2 = sigma**2
    across = s2 * model.walk_across / (1.0 + s2 * model.spectrum)
    noise = np.eye(model.n_unknowns) + s2 * (model.walk_fitted - across @ model.walk_across.T)
    return Estimate(
        values=model.solver @ (rotated.fitted - across @ rotated.left),
        covariance=model.solver @ noise @ model.solver.T,
    )


def misfit(model: WalkModel, left: NDArray[np.float64], sigma: float) -> float:
    """Weighted square sum of the residuals under a sigma of the walk: chi-square with m degrees if all holds."""
    return float(np.sum(left**2 / (1.0 + sigma**2 * model.spectrum)))


def walk_sigma(model: WalkModel, left: NDArray[np.float64]) -> WalkSigma:
    """REML of the walk's sigma and its likelihood as a density, from what the unknowns leave over (m,).

    Every sigma counts as equally likely before. A test that averages over the density keeps its level where one that
    takes REML for the truth does not (docs/monitoring.md).
    """
    if not model.random_walk:
        return WalkSigma(np.zeros(1), np.ones(1), None)
    return sigma_density(
        lambda sigmas: log_likelihood(model.spectrum, left, sigmas), _coarse_nodes(model.spectrum, left)
    )


def sigma_density(likelihood: Likelihood, coarse: NDArray[np.float64]) -> WalkSigma:
    """REML of a sigma and its likelihood as a density, from coarse nodes that hold all that counts."""
    heights = likelihood(coarse)
    best = int(np.argmax(heights))
    reml = _reml(likelihood, coarse[max(best - 1, 0)], coarse[min(best + 1, len(coarse) - 1)])
    counts = np.flatnonzero(heights > heights[best] - DROP)
    low, high = coarse[max(counts[0] - 1, 0)], coarse[min(counts[-1] + 1, len(coarse) - 1)]
    nodes = low + (high - low) * (np.arange(FINE_NODES) + 0.5) / FINE_NODES
    fine = likelihood(nodes)
    weights = np.exp(fine - fine.max())
    return WalkSigma(nodes, weights / weights.sum(), reml)


def log_likelihood(
    spectrum: NDArray[np.float64], left: NDArray[np.float64], sigmas: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Restricted log-likelihood (g,) of sigmas (g,), up to a constant."""
    taken = 1.0 + sigmas[:, None] ** 2 * spectrum
    return np.asarray(-0.5 * (np.log(taken).sum(axis=1) + (left**2 / taken).sum(axis=1)))


def _coarse_nodes(spectrum: NDArray[np.float64], left: NDArray[np.float64]) -> NDArray[np.float64]:
    """0 and sigmas from where the walk does not show to where it alone would be ten times too large."""
    seen = spectrum > 1e-9 * spectrum[-1]
    high = 10.0 * np.sqrt(np.mean((1.0 + left[seen] ** 2) / spectrum[seen]))
    low = 0.01 / np.sqrt(spectrum[-1])
    return np.concatenate([[0.0], np.geomspace(low, high, COARSE_NODES)])


def _reml(likelihood: Likelihood, low: float, high: float) -> float:
    """Maximum between two nodes beside the largest; 0 where nothing asks for a walk."""
    from scipy import optimize  # noqa: PLC0415 (slow to import)

    def height(sigma: float) -> float:
        return -float(likelihood(np.array([sigma]))[0])

    found = optimize.minimize_scalar(
        height, bounds=(low, high), method="bounded", options={"xatol": 1e-6 * high}
    )
    return 0.0 if low == 0.0 and height(0.0) <= found.fun else float(found.x)


def twofold(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix of both components, east and north in turn, from that of one."""
    return np.asarray(np.kron(matrix, np.eye(2)), dtype=np.float64)


def _whitened(factors: NDArray[np.float64], observed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Multiply observations (2n, ...) by the inverse Cholesky factors (n, 2, 2) of their epochs."""
    paired = observed.reshape(len(factors), 2, -1)
    first = paired[:, 0] / factors[:, 0, 0, None]
    second = (paired[:, 1] - factors[:, 1, 0, None] * first) / factors[:, 1, 1, None]
    return np.stack([first, second], axis=1).reshape(observed.shape)
