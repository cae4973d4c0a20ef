"""Series of movements with known truth."""

import numpy as np
from numpy.typing import NDArray

from tasks.trend import LeanSeries, Terms

LINE = Terms(rate=True, season=False, temperature=False, random_walk=False, reason="")
LINE_AND_WALK = Terms(rate=True, season=False, temperature=False, random_walk=True, reason="")


def irregular_times(rng: np.random.Generator, n: int) -> NDArray[np.float64]:
    """Half-yearly to yearly."""
    return np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 1.0, n - 1))])


def some_covariances(rng: np.random.Generator, n: int, sigma_m: float) -> NDArray[np.float64]:
    """Each epoch another ellipse, of about that sigma."""
    factors = sigma_m * (np.eye(2) + 0.4 * rng.standard_normal((n, 2, 2)))
    return factors @ factors.transpose(0, 2, 1) + 0.1 * sigma_m**2 * np.eye(2)


def drawn(
    rng: np.random.Generator,
    times: NDArray[np.float64],
    covariances: NDArray[np.float64],
    moved: NDArray[np.float64] | float = 0.0,
    walk: float = 0.0,
) -> LeanSeries:
    n = len(times)
    noise = np.einsum("nij,nj->ni", np.linalg.cholesky(covariances), rng.standard_normal((n, 2)))
    steps = np.sqrt(np.diff(times, prepend=times[0]))[:, None] * rng.standard_normal((n, 2))
    return LeanSeries(times, moved + noise + walk * np.cumsum(steps, axis=0), covariances)


def dense_covariance(series: LeanSeries, walk: float) -> NDArray[np.float64]:
    """Of all observations, east and north of each epoch in turn, written out."""
    n = series.n_epochs
    V = np.zeros((2 * n, 2 * n))
    for i in range(n):
        V[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = series.covariances[i]
        for j in range(n):
            elapsed = min(series.times[i], series.times[j]) - series.times[0]
            V[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] += walk**2 * elapsed * np.eye(2)
    return V
