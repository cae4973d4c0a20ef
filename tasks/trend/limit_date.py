"""When the deviation of a structure reaches an allowable one at the rate it has now."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.trend.outlook import Outlook

HORIZON_YEARS: Final = 100.0
"""Nothing is said of what lies further ahead."""

BOUND: Final = 0.05
"""Probability left beyond each of the two bounds."""

ACROSS_SIGMAS: Final = 8.0
ACROSS_NODES, ACROSS_WEIGHTS = np.polynomial.legendre.leggauss(24)
STEPS: Final = np.concatenate([[0.0], np.geomspace(0.01, HORIZON_YEARS, 63)])
"""Years ahead at which is looked first; between two of them the date is then narrowed down."""

NARROWINGS: Final = 3
MOST_NODES: Final = 24
"""Nodes of an outlook that are looked at, as many as one without a change point has; more are merged to these."""


@dataclass(frozen=True, slots=True)
class LimitDate:
    """Years after the last epoch at which the deviation reaches the limit; None if not within 100 years.

    ``expected`` is when the estimate reaches it. ``earliest`` is when its upper 95 % bound does: the limit is reached
    before then in at most 5 of 100 cases. ``latest`` is when the lower 95 % bound does: later in at most 5 of 100.
    0 where a value is there at the last epoch; ``reason`` says so.
    """

    expected: float | None
    earliest: float | None
    latest: float | None
    reason: str


def limit_date(outlook: Outlook, limit_m: float) -> LimitDate:
    """Extrapolate movement and rate as vectors until the length of the movement reaches a limit.

    The covariance at t years is that of movement + t rate, plus what is common to all epochs, plus what the random walk adds
    until then. Both bounds are those of the length of a vector, which near zero lean is never normal. The upper one counts
    every true vector as equally likely before, the lower one is the level at which a vector as long as the limit would
    show itself as long as estimated: each errs on the side of caution (earlier, later) where the lean is as small
    as its sigma, and elsewhere both agree with the formula for a single component.

    Parameters
    ----------
    outlook : Outlook
        State and rate at the last epoch.
    limit_m : float
        Allowable deviation, above 0, metres.

    Raises
    ------
    ShapeError
        If the limit is not above 0.
    """
    if not (np.isfinite(limit_m) and limit_m > 0.0):
        raise ShapeError(f"limit_date needs a limit above 0 m; got {limit_m!r}")
    ahead = _Ahead(merged(outlook), limit_m)
    expected = _first(ahead.expected_excess)
    earliest = _first(ahead.upper_excess)
    latest = _first(ahead.lower_excess)
    return LimitDate(expected, earliest, latest, _reason(expected, earliest, latest))


def _reason(expected: float | None, earliest: float | None, latest: float | None) -> str:
    if expected == 0.0:
        known = "and so is the lower bound" if latest == 0.0 else "though its lower 95 % bound is not"
        return f"the deviation is above the limit already at the last epoch, {known}"
    if earliest == 0.0:
        return "the upper 95 % bound of the deviation is above the limit already at the last epoch"
    if earliest is None:
        return "not within 100 years at this rate"
    return "at this rate"


@dataclass(frozen=True, slots=True)
class _Ahead:
    """An outlook and a limit; each method is positive at the years (t,) at which the limit is reached."""

    outlook: Outlook
    limit_m: float

    def expected_excess(self, years: NDArray[np.float64]) -> NDArray[np.float64]:
        """Length of the mean movement less the limit."""
        values, _ = self._at(years)
        return np.asarray(np.linalg.norm(self.outlook.weights @ values, axis=-1) - self.limit_m)

    def upper_excess(self, years: NDArray[np.float64]) -> NDArray[np.float64]:
        """Probability that the true movement is longer than the limit, less that of the bound."""
        values, covariances = self._at(years)
        inside = probability_inside(np.array(self.limit_m), values, covariances)
        return 1.0 - self._mean(inside) - BOUND

    def lower_excess(self, years: NDArray[np.float64]) -> NDArray[np.float64]:
        """Probability that a movement as long as the limit is found shorter than this one, less that of the bound."""
        values, covariances = self._at(years)
        sizes = np.linalg.norm(values, axis=-1)
        at_limit = values * (self.limit_m / np.maximum(sizes, 1e-300))[..., None]
        inside = probability_inside(sizes, at_limit, covariances)
        return self._mean(inside) - (1.0 - BOUND)

    def _mean(self, of_nodes: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.tensordot(of_nodes, self.outlook.weights, axes=(-1, 0)))

    def _at(self, years: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Movements (t, g, 2) that many years after the last epoch and their covariances (t, g, 2, 2)."""
        t = years[:, None, None]
        found, C = self.outlook, self.outlook.covariances
        across = C[:, :2, 2:] + np.swapaxes(C[:, :2, 2:], 1, 2)
        walked = found.walks[:, None, None] ** 2 * np.eye(2)
        t4 = t[..., None]
        covariances = C[:, :2, :2] + found.common + t4 * (across + walked) + t4**2 * C[:, 2:, 2:]
        return found.states[:, :2] + t * found.states[:, 2:], covariances


def probability_inside(
    radii: NDArray[np.float64], means: NDArray[np.float64], covariances: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Probability (...) that a normal vector lies inside a circle about the origin.

    Parameters
    ----------
    radii : (...) array
        Of the circles.
    means : (..., 2) array
    covariances : (..., 2, 2) array
        Positive definite.

    Notes
    -----
    The component along the mean is integrated in closed form, the one across by Gauss-Legendre over the part of 8 sigmas
    that the circle holds; in the angle, so that its edge does no harm.
    """
    from scipy import special  # noqa: PLC0415 (slow to import)

    sizes = np.linalg.norm(means, axis=-1)
    still = sizes == 0.0
    along = np.where(still[..., None], [1.0, 0.0], means / np.where(still, 1.0, sizes)[..., None])
    across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    aa, ac, cc = (
        np.einsum("...i,...ij,...j->...", u, covariances, v)
        for u, v in ((along, along), (along, across), (across, across))
    )
    sigma_across, held = np.sqrt(cc)[..., None], np.asarray(radii)[..., None]
    edge = np.arcsin(np.minimum(1.0, ACROSS_SIGMAS * sigma_across / np.maximum(held, 1e-300)))
    angles = edge * ACROSS_NODES
    offset, half_chord = held * np.sin(angles), held * np.cos(angles)
    mean = sizes[..., None] + (ac / cc)[..., None] * offset
    sigma = np.sqrt(aa - ac**2 / cc)[..., None]
    chord = special.ndtr((half_chord - mean) / sigma) - special.ndtr((-half_chord - mean) / sigma)
    density = np.exp(-0.5 * (offset / sigma_across) ** 2) / (np.sqrt(2 * np.pi) * sigma_across)
    return np.asarray(np.sum(ACROSS_WEIGHTS * edge * half_chord * density * chord, axis=-1))


def _first(excess: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> float | None:
    """First year at which a function of years turns positive, to a hundred-thousandth of the step around it."""
    years = STEPS
    for _ in range(NARROWINGS):
        above = np.flatnonzero(excess(years) >= 0.0)
        if len(above) == 0:
            return None
        if above[0] == 0:
            return float(years[0])
        years = np.linspace(years[above[0] - 1], years[above[0]], 16)
    return float(years[-1])


def merged(outlook: Outlook) -> Outlook:
    """Outlook of few nodes with the same mean and covariance: neighbours in their rate along its mean become one."""
    if len(outlook.weights) <= MOST_NODES:
        return outlook
    order = np.argsort(outlook.states[:, 2:] @ outlook.rate.value)
    ends = np.cumsum(outlook.weights[order])
    group = np.empty(len(order), dtype=np.intp)
    group[order] = np.minimum((ends * MOST_NODES).astype(np.intp), MOST_NODES - 1)
    share = np.zeros((MOST_NODES, len(order)))
    share[group, np.arange(len(order))] = outlook.weights
    share = share[share.sum(axis=1) > 0.0]
    weights = share.sum(axis=1)
    share /= weights[:, None]
    means = share @ outlook.states
    off = outlook.states - means[np.argmax(share, axis=0)]
    covariances = outlook.covariances + off[:, :, None] * off[:, None, :]
    return Outlook(
        weights,
        means,
        np.tensordot(share, covariances, axes=1),
        np.sqrt(share @ outlook.walks**2),
        outlook.common,
    )
