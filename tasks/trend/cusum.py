"""The control chart of a structure: what an epoch is off all earlier ones, summed up."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.trend.series import LeanSeries

ALLOWANCE: Final = 0.5
"""k of the CUSUM, sigmas: half of the shift that it finds fastest."""

WATCH_RUN_LENGTH: Final = 167.0
ALARM_RUN_LENGTH: Final = 455.0
"""Epochs on average from one false signal to the next."""

CHARTS: Final = 2
"""The two components of a lean are charted each by itself."""

NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
SETTLED_EPOCHS: Final = 300
"""After as many the probability of a signal at the next epoch no longer changes."""


@dataclass(frozen=True, slots=True)
class ControlChart:
    """The chart of a series; its first epoch has no earlier one and is not in it.

    Parameters
    ----------
    standardised : (n - 1, 2) array
        Every epoch against the weighted mean of all earlier ones, made independent and of unit variance: standard normal
        numbers as long as nothing changes.
    up, down : (n - 1, 2) arrays
        Upper and lower CUSUM of each component.
    """

    standardised: NDArray[np.float64]
    up: NDArray[np.float64]
    down: NDArray[np.float64]

    @property
    def largest(self) -> NDArray[np.float64]:
        """Largest of the four CUSUMs at each epoch (n - 1,)."""
        return np.asarray(np.maximum(self.up, self.down).max(axis=1))


def control_chart(series: LeanSeries, allowance: float = ALLOWANCE) -> ControlChart:
    """Chart a series by two-sided CUSUMs of both components.

    The chart is not set back after a signal. It tells that the structure is not where it was, by whatever: a steady rate
    and a random walk set it off, too, as they should. What is common to all epochs cancels.
    """
    standardised = recursive_residuals(series)
    return ControlChart(standardised, _sums(standardised, allowance), _sums(-standardised, allowance))


def recursive_residuals(series: LeanSeries) -> NDArray[np.float64]:
    """Epochs 2 to n against the weighted mean of all earlier ones, whitened (n - 1, 2).

    The mean is weighted by the full covariances; the difference is whitened by the Cholesky factor of its covariance. Under
    no change these are independent standard normal numbers, each epoch's of every other's.
    """
    found = np.empty((series.n_epochs - 1, 2))
    information, pull = np.zeros((2, 2)), np.zeros(2)
    for i, (movement, covariance) in enumerate(zip(series.movements, series.covariances, strict=True)):
        if i > 0:
            earlier = np.linalg.inv(information)
            factor = np.linalg.cholesky(covariance + earlier)
            found[i - 1] = np.linalg.solve(factor, movement - earlier @ pull)
        inverse = np.linalg.inv(covariance)
        information, pull = information + inverse, pull + inverse @ movement
    return found


def average_run_length(allowance: float, limit: float, shift: float = 0.0, charts: int = 1) -> float:
    """Epochs on average until the first of several two-sided CUSUMs reaches its limit, from a start at zero.

    The mean of the first chart is shifted from the start on, those of the others are not. For one chart it is exact up to
    quadrature: 1/ARL = 1/ARL up + 1/ARL down. For several the distribution of the run length of each is needed: that of its
    sides, brought to the exact mean.

    Parameters
    ----------
    allowance : float
        k, sigmas, not negative.
    limit : float
        h, above 0.
    shift : float
        Sigmas.
    charts : int
        How many independent components are charted, 1 or more.

    Raises
    ------
    ShapeError
        If a number is out of range.

    References
    ----------
    Page 1954; integral equation of van Dobben de Bruyn 1968, by Gauss-Legendre quadrature.
    """
    if not (allowance >= 0.0 and limit > 0.0 and np.isfinite(shift) and charts >= 1):
        raise ShapeError(
            "average_run_length needs k >= 0, h > 0, a finite shift and 1 or more charts; "
            f"got {allowance}, {limit}, {shift}, {charts}"
        )
    shifted = _two_sided(allowance, limit, shift)
    if charts == 1:
        return shifted.mean
    others = _two_sided(allowance, limit, 0.0)
    return _summed(shifted.survival() * others.survival() ** (charts - 1))


@lru_cache(maxsize=32)
def control_limit(run_length: float, allowance: float = ALLOWANCE, charts: int = CHARTS) -> float:
    """Limit h at which charts without any change signal every ``run_length`` epochs on average, all together.

    Raises
    ------
    ShapeError
        If no limit from 0.5 to 15 does.
    """
    from scipy import optimize  # noqa: PLC0415 (slow to import)

    def excess(limit: float) -> float:
        return average_run_length(allowance, limit, 0.0, charts) - run_length

    if not excess(0.5) < 0.0 < excess(15.0):
        raise ShapeError(f"control_limit needs a run length that a limit of 0.5 to 15 has; got {run_length}")
    return float(optimize.brentq(excess, 0.5, 15.0, xtol=1e-6))


@dataclass(frozen=True, slots=True)
class _TwoSided:
    """One chart: its exact average run length, and how probably its sides have not signalled after n epochs (n,)."""

    mean: float
    sides: NDArray[np.float64]

    def survival(self) -> NDArray[np.float64]:
        """Probability (n,) that neither side has signalled after 0, 1, 2, ... epochs, of the exact mean.

        The sides are not quite independent: their product is a little too long, by a power that is near 1.
        """
        from scipy import optimize  # noqa: PLC0415 (slow to import)

        power = optimize.brentq(lambda tried: _summed(self.sides**tried) - self.mean, 0.5, 2.0)
        return np.asarray(self.sides**power)


def _two_sided(allowance: float, limit: float, shift: float) -> _TwoSided:
    up, down = (_one_sided(allowance - drift, limit) for drift in (shift, -shift))
    lengths = [np.linalg.solve(np.eye(len(T)) - T, np.ones(len(T)))[0] for T in (up, down)]
    return _TwoSided(
        1.0 / (1.0 / float(lengths[0]) + 1.0 / float(lengths[1])), _survival(up) * _survival(down)
    )


def _one_sided(against: float, limit: float) -> NDArray[np.float64]:
    """Transitions of one CUSUM below its limit, from 0 and the nodes to 0 and the nodes with their weights."""
    from scipy import special  # noqa: PLC0415 (slow to import)

    nodes = np.concatenate([[0.0], limit * (NODES + 1.0) / 2.0])
    T = np.empty((len(nodes), len(nodes)))
    T[:, 0] = special.ndtr(against - nodes)
    steps = nodes[None, 1:] - nodes[:, None] + against
    T[:, 1:] = limit / 2.0 * WEIGHTS * np.exp(-0.5 * steps**2) / np.sqrt(2.0 * np.pi)
    return T


def _survival(transitions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Probability of no signal after 0, 1, ... epochs from a start at zero, until it falls by the same factor each epoch."""
    state = np.ones(len(transitions))
    found = np.ones(SETTLED_EPOCHS)
    for n in range(1, SETTLED_EPOCHS):
        state = transitions @ state
        found[n] = state[0]
    return found


def _summed(survival: NDArray[np.float64]) -> float:
    """Mean run length: the sum of the survival, whose tail is a geometric series."""
    last = survival[-1]
    factor = last / survival[-2] if last > 0.0 else 0.0
    return float(survival.sum() + last * factor / (1.0 - factor))


def _sums(standardised: NDArray[np.float64], allowance: float) -> NDArray[np.float64]:
    found = np.zeros_like(standardised)
    state = np.zeros(2)
    for i, values in enumerate(standardised):
        state = np.maximum(0.0, state + values - allowance)
        found[i] = state
    return found
