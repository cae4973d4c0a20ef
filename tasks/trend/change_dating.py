"""When a change began and what it changed, averaged over the onsets and random walks that the movements allow."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.trend.gls import LONG_EPOCHS, state_covariance
from tasks.trend.long_series import chain_model, chain_sigma
from tasks.trend.onsets import Kind, Onsets, blocks_of, change_column, change_columns, onsets_between
from tasks.trend.outlook import Outlook, PlaneVector, mean_of
from tasks.trend.series import LeanSeries
from tasks.trend.walk import Rotated, WalkModel, WalkSigma, build_model, estimate, rotate, walk_sigma

PARTS: Final = 8
"""Parts of an interval between two epochs, to date an onset."""

LEAST_WEIGHT: Final = 1e-5
"""Of the heaviest node; lighter ones change no figure."""

CREDIBLE: Final = 0.95

MOST_NUMBERS: Final = 2**22
"""Numbers in the columns of the changes that are looked at together: eight onsets an epoch grow with its square."""


@dataclass(frozen=True, slots=True)
class DatedChange:
    """Onset in years with its 95 % interval, the change, both rates and the outlook with the rate after it."""

    time: float
    earliest: float
    latest: float
    change: PlaneVector
    rate_before: PlaneVector
    rate_after: PlaneVector
    outlook: Outlook


@dataclass(frozen=True, slots=True)
class _Nodes:
    """Every onset (k of them) under every sigma of the walk: vectors (g, 6) of movement and rate at the end, and change."""

    logs: NDArray[np.float64]
    values: NDArray[np.float64]
    covariances: NDArray[np.float64]
    onsets: NDArray[np.intp]
    walks: NDArray[np.float64]


def date_change(
    series: LeanSeries, columns: NDArray[np.float64], model: WalkModel, kind: Kind, near: float
) -> DatedChange:
    """Date a change of a kind and tell the rates on either side.

    Every onset between two epochs counts as equally likely before, and by the likelihood of the best change there after.
    The sigmas of the random walk are those that go with the onset ``near``, so that the change is not taken for a walk.

    Parameters
    ----------
    series : LeanSeries
        Movements over the epochs.
    columns : (n, p) array
        What else moves the structure: level, rate, ...
    model : WalkModel
        That of the series and these columns, with or without a random walk.
    kind : "step" or "rate"
        What changed.
    near : float
        The best onset of a scan, years.
    """
    onsets = onsets_between(series, kind, PARTS)
    beside = np.column_stack([columns, change_column(series, kind, near)])
    sigmas = _walk_sigma(series, beside, model.random_walk).nodes[::2]
    nodes = _likely(_joined(model, series, onsets, sigmas))
    weights = np.exp(nodes.logs)
    return _dated(nodes, weights / weights.sum(), onsets, series.common)


def _walk_sigma(series: LeanSeries, columns: NDArray[np.float64], random_walk: bool) -> WalkSigma:
    if random_walk and series.n_epochs > LONG_EPOCHS:
        return chain_sigma(chain_model(series, columns))
    model = build_model(series, columns, random_walk)
    return walk_sigma(model, rotate(model, series.movements.reshape(-1)).left)


def _likely(nodes: _Nodes) -> _Nodes:
    """Those nodes that count, their logarithms from the heaviest down."""
    logs = nodes.logs - nodes.logs.max()
    kept = logs > np.log(LEAST_WEIGHT)
    return _Nodes(
        logs[kept], nodes.values[kept], nodes.covariances[kept], nodes.onsets[kept], nodes.walks[kept]
    )


def _dated(
    nodes: _Nodes, weights: NDArray[np.float64], onsets: Onsets, common: NDArray[np.float64]
) -> DatedChange:
    likely = np.asarray(np.bincount(nodes.onsets, weights, len(onsets.times)), dtype=np.float64)
    held = _densest(likely, likely / onsets.widths)
    turned = 1.0 if onsets.kind == "rate" else 0.0
    B = np.hstack([np.zeros((2, 2)), np.eye(2), -turned * np.eye(2)])
    values, C = nodes.values, nodes.covariances
    return DatedChange(
        time=float(onsets.times[np.argmax(likely / onsets.widths)]),
        earliest=float((onsets.times - onsets.widths / 2.0)[held].min()),
        latest=float((onsets.times + onsets.widths / 2.0)[held].max()),
        change=mean_of(weights, values[:, 4:], C[:, 4:, 4:]),
        rate_before=mean_of(weights, values @ B.T, B @ C @ B.T),
        rate_after=mean_of(weights, values[:, 2:4], C[:, 2:4, 2:4]),
        outlook=Outlook(weights, values[:, :4], C[:, :4, :4], nodes.walks, common),
    )


def _densest(likely: NDArray[np.float64], densities: NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of the densest onsets that hold 95 % together."""
    order = np.argsort(densities, kind="stable")[::-1]
    enough = int(np.searchsorted(np.cumsum(likely[order]), CREDIBLE)) + 1
    return order[:enough]


def _joined(model: WalkModel, series: LeanSeries, onsets: Onsets, sigmas: NDArray[np.float64]) -> _Nodes:
    observed = rotate(model, series.movements.reshape(-1))
    k, g = len(onsets.times), len(sigmas)
    blocks = []
    for block in blocks_of(onsets, max(1, MOST_NUMBERS // (4 * series.n_epochs))):
        changes = rotate(model, change_columns(series, block))
        blocks.append([_under(model, observed, changes, float(sigma)) for sigma in sigmas])
    under = [_end_to_end(parts) for parts in zip(*blocks, strict=True)]
    scales = under[g // 2].log_information
    logs = [one.log_likelihood - 0.5 * (one.log_information - scales) for one in under]
    return _Nodes(
        logs=np.concatenate(logs) + np.tile(np.log(onsets.widths), g),
        values=np.concatenate([one.values for one in under]),
        covariances=np.concatenate([one.covariances for one in under]),
        onsets=np.tile(np.arange(k), g),
        walks=np.repeat(sigmas, k),
    )


@dataclass(frozen=True, slots=True)
class _Under:
    """All onsets (k) under one sigma of the walk; ``log_information`` is that of the determinant of the change's."""

    log_likelihood: NDArray[np.float64]
    log_information: NDArray[np.float64]
    values: NDArray[np.float64]
    covariances: NDArray[np.float64]


def _end_to_end(blocks: Sequence[_Under]) -> _Under:
    return _Under(
        log_likelihood=np.concatenate([one.log_likelihood for one in blocks]),
        log_information=np.concatenate([one.log_information for one in blocks]),
        values=np.concatenate([one.values for one in blocks]),
        covariances=np.concatenate([one.covariances for one in blocks]),
    )


def _under(model: WalkModel, observed: Rotated, changes: Rotated, sigma: float) -> _Under:
    """Add every change to the estimate without one: what it explains of the residuals, and what that takes of the rest."""
    taken = 1.0 + sigma**2 * model.spectrum
    H = changes.left.T.reshape(-1, 2, len(taken))
    information = (H / taken) @ H.transpose(0, 2, 1)
    within = np.linalg.inv(information)
    pull = (H / taken) @ observed.left
    found = np.einsum("kij,kj->ki", within, pull)
    plain = estimate(model, observed, sigma)
    J = estimate(model, changes, sigma).values[:4].reshape(4, -1, 2).transpose(1, 0, 2)
    across = -J @ within
    state = state_covariance(plain.covariance[:4, :4], model.span, sigma) - across @ J.transpose(0, 2, 1)
    without = np.log(taken).sum() + np.sum(observed.left**2 / taken)
    return _Under(
        log_likelihood=-0.5 * (without - np.sum(pull * found, axis=1)),
        log_information=np.linalg.slogdet(information).logabsdet,
        values=np.hstack([plain.values[:4] - np.einsum("kij,kj->ki", J, found), found]),
        covariances=np.block([[state, across], [across.transpose(0, 2, 1), within]]),
    )
