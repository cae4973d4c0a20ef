"""How many harmonics of a radius profile the points of a slice show."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from tasks.contours.robust_adjustment import RobustFit

PRICE: Final = 0.02
"""What a search for harmonics may add to the variance of the centre of a round shaft, as a part of it."""


@dataclass(frozen=True, slots=True)
class OrderChoice:
    """An order and by how much its Bayesian information criterion lies above that of the circle (below: negative).

    For a circle it is the least of the orders that were tried, ``runner_up``.
    """

    order: int
    runner_up: int
    bic_over_circle: float


def choose_order(fit: RobustFit, orders: tuple[int, ...]) -> OrderChoice:
    """Choose a profile among the circle and ``orders``, from a fit of the highest of them.

    What the harmonics up to K explain is a Wald statistic of those above K, so that one fit serves all orders; its
    covariance is the robust one. K has to lower the criterion, and on an arc more: a chance find turns a good centre
    of a circle into the poor one of a profile. The find is taken only if it is so large that on round shafts the mean
    square of the centre grows by at most ``PRICE``. On a full ring that asks nothing beyond the criterion.

    Parameters
    ----------
    fit : RobustFit
        Of a profile with harmonics 2 to ``orders[-1]``: parameters east, north, radius, cos 2, sin 2, ...
    orders : tuple of int
        Rising, each 2 or more.

    References
    ----------
    Schwarz 1978, Annals of Statistics 6; Machado 1993, Econometric Theory 9 (its robust form).
    """
    explained_by_all = _wald(fit, 0)
    circle = _center_variance(fit, 0)
    best = OrderChoice(0, orders[0], np.inf)
    for order in orders:
        count = 2 * (order - 1)
        explained = explained_by_all - _wald(fit, count)
        over = count * float(np.log(int(fit.used.sum()))) - explained
        needed = _least_find(_center_variance(fit, count) / circle - 1.0, count)
        taken = over < 0.0 and explained >= needed
        if (taken, -over) > (best.order > 0, -best.bic_over_circle):
            best = OrderChoice(order if taken else 0, order, over)
    return best


def _wald(fit: RobustFit, kept: int) -> float:
    """Squared length of the coefficients from ``kept`` on, in their own standard deviations."""
    dropped = slice(3 + kept, None)
    covariance = fit.covariance_m2()[dropped, dropped]
    values = fit.parameters_m[dropped]
    return float(values @ np.linalg.solve(covariance, values)) if len(values) else 0.0


def _center_variance(fit: RobustFit, count: int) -> float:
    """Trace of the covariance of the centre with ``count`` coefficients, in units of the variance of a point."""
    return float(np.trace(np.linalg.inv(fit.normal[: 3 + count, : 3 + count])[:2, :2]))


def _least_find(growth: float, count: int) -> float:
    """Smallest chi-square of ``count`` coefficients at which chance finds cost no more than ``PRICE``.

    Coefficients that are noise add ``growth`` times the part of their mean square beyond the threshold to the variance.
    """
    if growth <= PRICE:
        return 0.0
    from scipy.special import chdtri  # noqa: PLC0415 (slow to import, and every command reads settings)

    return float(chdtri(count + 2.0, PRICE / growth))
