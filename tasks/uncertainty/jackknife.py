"""The lean with one station left out after the other, and which covariance is then stated."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.plane_vectors import small_sample_factor

LEAST_STATIONS: Final = 5
"""With fewer stations the scatter of what is left tells nothing."""

MISFIT_LEVEL: Final = 0.02
"""Probability with which stations that fit their stated errors are taken for ones that do not."""

Source = Literal["propagation", "jackknife"]


@dataclass(frozen=True, slots=True, eq=False)
class Stated:
    """The covariance (2, 2) of a lean vector that is stated, that of the jackknife, and which of the two counts.

    ``misfit_p`` is the probability of stations that disagree like these if their stated errors hold. Both are None where
    there are too few stations.
    """

    covariance: NDArray[np.float64]
    jackknife: NDArray[np.float64] | None
    source: Source
    misfit_p: float | None


def jackknife_covariance(changes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (2, 2) from the changes (n, 2) of the lean with one of n stations left out: (n - 1) / n sum d d'.

    Raises
    ------
    ShapeError
        If there are fewer than ``LEAST_STATIONS`` changes, or they are not finite.

    References
    ----------
    Efron & Stein 1981, The jackknife estimate of variance, Annals of Statistics 9.
    """
    if changes.ndim != 2 or changes.shape[1] != 2 or len(changes) < LEAST_STATIONS:
        raise ShapeError(
            f"jackknife_covariance needs changes (n, 2) of at least {LEAST_STATIONS} stations, got {changes.shape}"
        )
    if not np.isfinite(changes).all():
        raise ShapeError("jackknife_covariance needs finite changes")
    n = len(changes)
    away = changes - changes.mean(axis=0)
    return np.asarray((n - 1) / n * away.T @ away)


def state_covariance(propagated: NDArray[np.float64], changes: NDArray[np.float64] | None) -> Stated:
    """Choose the honest one of two covariances: that of propagation, unless the stations contradict it.

    Propagation knows errors that all stations share, the jackknife errors that nobody stated. If the stations scatter more
    than propagation allows (2 %), the larger of both counts in every direction; the jackknife is then widened for the few
    stations behind it (Hotelling), so that the chi-square region of 95 % is one.

    Parameters
    ----------
    propagated : (2, 2) array
        Covariance of the lean vector by propagation, positive definite.
    changes : (n, 2) array or None
        Change of the lean with each station left out; None where that cannot be said.
    """
    from scipy.special import gammaincc  # noqa: PLC0415 (slow to import)

    if changes is None or len(changes) < LEAST_STATIONS:
        return Stated(propagated, None, "propagation", None)
    n, jackknife = len(changes), jackknife_covariance(changes)
    statistic = (n - 1) * float(np.trace(np.linalg.solve(propagated, jackknife)))
    p_value = float(gammaincc(n - 1.0, statistic / 2.0))
    if p_value >= MISFIT_LEVEL:
        return Stated(propagated, jackknife, "propagation", p_value)
    wide = jackknife * hotelling_factor(n)
    return Stated(_larger(propagated, wide), jackknife, "jackknife", p_value)


def hotelling_factor(n: int) -> float:
    """Factor that makes the chi-square region of a covariance from n stations hold in 95 of 100: F(2, n - 2)."""
    return (n - 1) / (n - 2) * small_sample_factor(n - 2)


def _larger(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (2, 2) that is at least as large as both in every direction of their common axes."""
    root = np.linalg.cholesky(first)
    inverse = np.linalg.inv(root)
    ratios, turns = np.linalg.eigh(inverse @ second @ inverse.T)
    back = root @ turns
    return np.asarray(back * np.maximum(ratios, 1.0) @ back.T)
