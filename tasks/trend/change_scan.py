"""How much better a change point explains a series than none, and how often chance alone explains it as well."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.trend.walk import WalkModel, WalkSigma

SCAN_NODES: Final = 15
SCAN_RANGE: Final = 40.0
"""Sigmas of the walk that are tried: none, and from the largest likely one down to this part of it."""

BATCH: Final = 500
MOST_SIMULATED: Final = 4000
ENOUGH_EXCEEDING: Final = 25
ENOUGH_WITHOUT: Final = 1000
"""Simulation ends when the answer is clear: 25 series exceed, or none of 1000 does."""


@dataclass(frozen=True, slots=True)
class Scan:
    """The likelihood ratio of the best change, ready for many series: see ``scan_of``."""

    log_determinants: NDArray[np.float64]
    inverses: NDArray[np.float64]
    whiteners: NDArray[np.float64]


def scan_of(model: WalkModel, candidates: NDArray[np.float64], walk: WalkSigma) -> Scan:
    """Prepare the scan of a model: every candidate under every sigma of the walk that is tried.

    ``candidates`` (k, 2, m): the two columns of each change in the residuals of the unknowns.
    """
    taken = 1.0 + scan_sigmas(walk)[:, None] ** 2 * model.spectrum
    return Scan(
        log_determinants=np.log(taken).sum(axis=1),
        inverses=1.0 / taken,
        whiteners=np.array([_whitener(candidates, row) for row in taken]),
    )


def scan_sigmas(walk: WalkSigma) -> NDArray[np.float64]:
    """Sigmas (g,) of the walk that a scan tries."""
    if walk.reml is None:
        return np.zeros(1)
    largest = float(walk.nodes[-1])
    return np.concatenate([[0.0], np.geomspace(largest / SCAN_RANGE, largest, SCAN_NODES)])


def likelihood_ratios(scan: Scan, left: NDArray[np.float64]) -> NDArray[np.float64]:
    """Twice the gain in log-likelihood (k, N) of every candidate over no change, in series whose residuals are (m, N).

    The sigma of the walk is the best one for each: without a change it has to make up for one.
    """
    without = scan.log_determinants[:, None] + scan.inverses @ left**2
    best = np.full((scan.whiteners.shape[1] // 2, left.shape[1]), np.inf)
    for whitener, plain in zip(scan.whiteners, without, strict=True):
        found = (whitener @ left) ** 2
        np.minimum(best, plain - (found[0::2] + found[1::2]), out=best)
    return np.asarray(without.min(axis=0) - best)


def scan_p_value(
    model: WalkModel, scan: Scan, walk: WalkSigma, statistic: float, rng: np.random.Generator
) -> float:
    """Share of series without any change whose best candidate gains as much or more.

    The sigma of the walk of each simulated series is drawn from what the observations tell of it. At least 1 of (number
    simulated + 1); a p value near 1 rests on few series, one near 0.01 on 4000.
    """
    exceeding, simulated = 0, 0
    while simulated < MOST_SIMULATED:
        sigmas = rng.choice(walk.nodes, size=BATCH, p=walk.weights)
        spread = np.sqrt(1.0 + sigmas**2 * model.spectrum[:, None])
        drawn = likelihood_ratios(scan, spread * rng.standard_normal(spread.shape)).max(axis=0)
        exceeding += int(np.count_nonzero(drawn >= statistic))
        simulated += BATCH
        if exceeding >= ENOUGH_EXCEEDING or (exceeding == 0 and simulated >= ENOUGH_WITHOUT):
            break
    return (exceeding + 1) / (simulated + 1)


def _whitener(candidates: NDArray[np.float64], taken: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows (2k, m) that turn residuals into the two independent components of every candidate, of unit variance."""
    weighted = candidates / taken
    factors = np.linalg.cholesky(weighted @ candidates.transpose(0, 2, 1))
    return np.asarray(np.linalg.solve(factors, weighted).reshape(-1, len(taken)))
