"""The model of ``walk`` for series of many epochs, whose cost grows as their number and not as its cube.

The random walk is a chain: its precision matrix couples neighbours only, so that for one sigma estimate, likelihood and
misfit follow from a banded Cholesky factor. ``walk`` takes the model apart once for all sigmas, which is cheaper up to some
hundred epochs and needs minutes for some thousand.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.trend.series import LeanSeries
from tasks.trend.terms import DAYS_A_YEAR
from tasks.trend.walk import COARSE_NODES, Estimate, WalkSigma, sigma_density, twofold

SAME_TIME: Final = 1.0 / (86_400.0 * DAYS_A_YEAR)
"""A second, in years. The bond of the walk between two times grows as their distance shrinks, and drowns the epochs in
rounding: at a microsecond no digit is left. Within a second no structure wanders."""


@dataclass(frozen=True, slots=True)
class AtSigma:
    """What a sigma of the walk gives: restricted log-likelihood up to a constant, estimate, weighted square sum."""

    log_likelihood: float
    estimate: Estimate
    misfit: float


@dataclass(frozen=True, slots=True)
class ChainModel:
    """A series and the columns of its model, summed up by the times at which the walk is asked for.

    ``observed`` (2p + 1, 2p + 1) are the products of all columns and of what they leave of the movements (last) under the
    covariances of the epochs; ``at_times`` (2m, 2p + 1) the same columns summed by time, ``precision`` (m, 2, 2) the
    precisions of the epochs; ``steps`` (m,) are the years from one time to the next.
    """

    start: NDArray[np.float64]
    log_noise: float
    observed: NDArray[np.float64]
    at_times: NDArray[np.float64]
    precision: NDArray[np.float64]
    steps: NDArray[np.float64]
    coarse: NDArray[np.float64]


def chain_model(series: LeanSeries, columns: NDArray[np.float64]) -> ChainModel:
    """Sum up a series for the columns (n, p) of one component; both have the same.

    Epochs no more than ``SAME_TIME`` apart are taken as of one time, as far as the walk is asked for.

    Raises
    ------
    ShapeError
        If the columns are not (n, p), depend on each other, or all epochs lie at one time.
    """
    n = series.n_epochs
    is_later = np.append(True, np.diff(series.times) > SAME_TIME)
    times, place = series.times[is_later], np.cumsum(is_later) - 1
    if columns.shape[0] != n or len(times) < 2:
        raise ShapeError(f"chain_model needs columns (n, p) with n = {n} and 2 times; got {columns.shape}")
    X = twofold(columns).reshape(n, 2, -1)
    precisions = np.asarray(np.linalg.inv(series.covariances), dtype=np.float64)
    start = _start(X, precisions, series.movements)
    left = series.movements - X @ start
    Z = np.concatenate([X, left[:, :, None]], axis=2)
    weighted = precisions @ Z
    summed, at_times = np.zeros((len(times), 2, 2)), np.zeros((len(times), 2, Z.shape[2]))
    np.add.at(summed, place, precisions)
    np.add.at(at_times, place, weighted)
    return ChainModel(
        start=start,
        log_noise=float(np.linalg.slogdet(series.covariances)[1].sum()),
        observed=np.einsum("nik,nil->kl", Z, weighted),
        # the walk is zero at the first time
        at_times=at_times[1:].reshape(-1, Z.shape[2]),
        precision=summed[1:],
        steps=np.diff(times),
        coarse=_coarse_nodes(series, left, precisions),
    )


def at_sigma(model: ChainModel, sigma: float) -> AtSigma:
    """Generalised least squares under a sigma of the walk."""
    log_size, products = model.log_noise, model.observed
    if sigma > 0.0:
        log_walk, taken = _walk(model, sigma)
        log_size, products = log_size + log_walk, products - taken
    information, towards = products[:-1, :-1], products[:-1, -1]
    covariance = np.linalg.inv(information)
    moved = covariance @ towards
    misfit = float(products[-1, -1] - towards @ moved)
    likelihood = -0.5 * (log_size + float(np.linalg.slogdet(information)[1]) + misfit)
    return AtSigma(likelihood, Estimate(model.start + moved, (covariance + covariance.T) / 2.0), misfit)


def chain_sigma(model: ChainModel) -> WalkSigma:
    """REML of the walk's sigma and its likelihood as a density, as ``walk.walk_sigma``."""

    def likelihood(sigmas: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.array([at_sigma(model, float(sigma)).log_likelihood for sigma in sigmas])

    return sigma_density(likelihood, model.coarse)


def _walk(model: ChainModel, sigma: float) -> tuple[float, NDArray[np.float64]]:
    """What the walk adds to the log-determinant of the covariance, and takes from the products."""
    from scipy import linalg  # noqa: PLC0415 (slow to import)

    m = len(model.steps)
    bonds = 1.0 / (sigma**2 * model.steps)
    band = np.zeros((3, 2 * m))
    own = bonds + np.append(bonds[1:], 0.0)
    band[0] = np.repeat(own, 2) + model.precision[:, [0, 1], [0, 1]].reshape(-1)
    band[1, ::2] = model.precision[:, 1, 0]
    band[2, : 2 * m - 2] = np.repeat(-bonds[1:], 2)
    factor = linalg.cholesky_banded(band, lower=True, check_finite=False)
    solved = linalg.cho_solve_banded((factor, True), model.at_times, check_finite=False)
    log_size = 2.0 * np.log(factor[0]).sum() - 2.0 * np.log(bonds).sum()
    return float(log_size), np.asarray(model.at_times.T @ solved, dtype=np.float64)


def _start(
    X: NDArray[np.float64], precisions: NDArray[np.float64], movements: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Least squares without a walk: what is left of the movements is small, and so are the errors of its sums."""
    factors = np.linalg.cholesky(precisions)
    white = (factors.transpose(0, 2, 1) @ X).reshape(-1, X.shape[2])
    observed = np.einsum("nji,nj->ni", factors, movements).reshape(-1)
    found, _, rank, _ = np.linalg.lstsq(white, observed, rcond=1e-12)
    if rank < X.shape[2]:
        raise ShapeError("chain_model needs columns that do not depend on each other")
    return np.asarray(found, dtype=np.float64)


def _coarse_nodes(
    series: LeanSeries, left: NDArray[np.float64], precisions: NDArray[np.float64]
) -> NDArray[np.float64]:
    """0 and sigmas from where the walk does not show to where it alone would be ten times too large."""
    elapsed = series.times - series.times[0]
    shows = float(np.einsum("n,nii->", elapsed, precisions))
    apart = np.diff(series.times)
    noise = np.einsum("nii->n", series.covariances)
    jumps = (np.diff(left, axis=0) ** 2).sum(axis=1) + noise[1:] + noise[:-1]
    high = 10.0 * np.sqrt(np.mean(jumps[apart > SAME_TIME] / apart[apart > SAME_TIME]))
    return np.concatenate([[0.0], np.geomspace(0.01 / np.sqrt(shows), high, COARSE_NODES)])
