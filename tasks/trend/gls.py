"""The trend of a structure: generalised least squares of both components with a random walk of unknown size."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.trend.long_series import at_sigma, chain_model, chain_sigma
from tasks.trend.outlook import Outlook, PlaneVector, mean_of
from tasks.trend.series import LeanSeries
from tasks.trend.terms import Terms, choose_terms, design_columns
from tasks.trend.walk import (
    Estimate,
    WalkSigma,
    build_model,
    estimate,
    misfit,
    rotate,
    walk_sigma,
)

LONG_EPOCHS: Final = 200
"""Above, a series is taken for a chain, which gives the same and costs less; below, the figures stay to the last bit."""


@dataclass(frozen=True, slots=True)
class Size:
    """A length and its standard deviation."""

    value: float
    sigma: float


@dataclass(frozen=True, slots=True)
class Trend:
    """How the axis goes on; see ``fit_trend``.

    ``outlook`` holds movement and rate at the last epoch with their covariance, ``random_walk`` the REML sigma of a
    component after one year (None where the model has none), ``season`` the larger half-axis of the yearly swing,
    ``temperature`` metres a kelvin.
    """

    terms: Terms
    outlook: Outlook
    random_walk: float | None
    season: Size | None
    temperature: Size | None
    misfit_p: float | None

    @property
    def rate(self) -> PlaneVector:
        """Rate with its covariance, metres a year."""
        return self.outlook.rate

    @property
    def rate_p_value(self) -> float:
        """Probability of such a rate or a larger one if there is none."""
        return self.outlook.rate_p_value


def fit_trend(
    series: LeanSeries, terms: Terms | None = None, extra: NDArray[np.float64] | None = None
) -> Trend | FitFailure:
    """Fit level, rate, season, temperature and random walk to both components at once.

    x(t) = x0 + v t + A cos 2 pi t + B sin 2 pi t + c (T - mean) + random walk + noise of the epoch. The covariance is
    that of the epochs plus sigma^2 min(t_i - t_0, t_j - t_0) for each component. sigma is not known: all results are
    averaged over its REML likelihood, because a test that puts the best sigma for the true one finds rates where there
    are none in up to 24 of 100 cases instead of 5.

    Parameters
    ----------
    series : LeanSeries
        Movements over the epochs.
    terms : Terms or None
        The terms; None chooses them by the epochs (``choose_terms``).
    extra : (n, q) array or None
        More columns of one component, as of a change that was found.

    Returns
    -------
    Trend or FitFailure
        The failure says why there is no rate.

    Notes
    -----
    It is assumed that the covariances of the epochs hold; ``misfit_p`` is small where the residuals contradict them.
    Without random walk (below 6 epochs) the p value holds only for a structure that does not wander.
    """
    chosen = choose_terms(series) if terms is None else terms
    if not chosen.rate:
        return FitFailure(chosen.reason)
    columns = design_columns(series, chosen)
    if extra is not None:
        columns = np.column_stack([columns, extra])
    if columns.shape[1] >= series.n_times:
        return FitFailure(f"no rate: {columns.shape[1]} unknowns of {series.n_times} epochs")
    long = chosen.random_walk and series.n_epochs > LONG_EPOCHS
    found = _chained(series, columns) if long else _taken_apart(series, columns, chosen.random_walk)
    fits, sigma = found.fits, found.sigma
    return Trend(
        terms=chosen,
        outlook=_outlook(fits, sigma, series.span, series.common),
        random_walk=sigma.reml,
        season=_season(fits, sigma) if chosen.season else None,
        temperature=_temperature(fits, sigma, chosen) if chosen.temperature else None,
        misfit_p=_misfit_p(2 * series.n_epochs - 2 * columns.shape[1], found.misfit),
    )


@dataclass(frozen=True, slots=True)
class _Fits:
    """Estimates at the nodes of a sigma of the walk, and the weighted square sum of residuals under its REML."""

    fits: list[Estimate]
    sigma: WalkSigma
    misfit: float


def _taken_apart(series: LeanSeries, columns: NDArray[np.float64], random_walk: bool) -> _Fits:
    model = build_model(series, columns, random_walk)
    rotated = rotate(model, series.movements.reshape(-1))
    sigma = walk_sigma(model, rotated.left)
    fits = [estimate(model, rotated, node) for node in sigma.nodes]
    return _Fits(fits, sigma, misfit(model, rotated.left, 0.0 if sigma.reml is None else sigma.reml))


def _chained(series: LeanSeries, columns: NDArray[np.float64]) -> _Fits:
    model = chain_model(series, columns)
    sigma = chain_sigma(model)
    fits = [at_sigma(model, float(node)).estimate for node in sigma.nodes]
    return _Fits(fits, sigma, at_sigma(model, sigma.reml or 0.0).misfit)


def gls_at(series: LeanSeries, columns: NDArray[np.float64], sigma: float) -> Estimate:
    """Generalised least squares of columns (n, p) under a random walk of known sigma.

    Raises
    ------
    ShapeError
        See ``build_model``.
    """
    model = build_model(series, columns, random_walk=True)
    return estimate(model, rotate(model, series.movements.reshape(-1)), sigma)


def state_covariance(within: NDArray[np.float64], span: float, sigma: float) -> NDArray[np.float64]:
    """Covariance (4, 4) of movement at the last epoch and rate, from that of level and rate and the sigma of the walk.

    The structure is where the walk has brought it, the level is where the line alone is. The best guess of the walk at the
    last epoch is zero whatever was measured, because a walk that began at the first epoch goes with the epochs as the
    rate does; so the values stay, and the covariance loses sigma^2 span of the movement and sigma^2 across.
    """
    taken = np.zeros((4, 4))
    taken[:2, :2] = span * np.eye(2)
    taken[:2, 2:] = taken[2:, :2] = np.eye(2)
    return within - sigma**2 * taken


def _outlook(fits: list[Estimate], sigma: WalkSigma, span: float, common: NDArray[np.float64]) -> Outlook:
    covariances = [
        state_covariance(fit.covariance[:4, :4], span, node)
        for fit, node in zip(fits, sigma.nodes, strict=True)
    ]
    return Outlook(
        weights=sigma.weights,
        states=np.array([fit.values[:4] for fit in fits]),
        covariances=np.array(covariances),
        walks=sigma.nodes,
        common=common,
    )


def _misfit_p(freedom: int, square_sum: float) -> float:
    """Tail probability of the weighted square sum of residuals under the REML sigma."""
    from scipy import special  # noqa: PLC0415 (slow to import)

    return float(special.chdtrc(freedom, square_sum))


def _temperature(fits: list[Estimate], sigma: WalkSigma, terms: Terms) -> Size:
    at = 8 if terms.season else 4
    values = np.array([fit.values[at : at + 2] for fit in fits])
    covariances = np.array([fit.covariance[at : at + 2, at : at + 2] for fit in fits])
    found = mean_of(sigma.weights, values, covariances)
    return Size(found.size, found.sigma)


def _season(fits: list[Estimate], sigma: WalkSigma) -> Size:
    """Larger half-axis of the ellipse that the yearly swing draws, with its sigma to first order."""
    values = np.array([fit.values[4:8] for fit in fits])
    covariances = np.array([fit.covariance[4:8, 4:8] for fit in fits])
    swing = sigma.weights @ values
    U, sizes, Vt = np.linalg.svd(swing.reshape(2, 2))
    along = np.outer(U[:, 0], Vt[0]).reshape(-1)
    spread = sigma.weights @ ((values - swing) @ along) ** 2
    variance = along @ np.einsum("g,gij->ij", sigma.weights, covariances) @ along + spread
    return Size(float(sizes[0]), float(np.sqrt(variance)))
