"""Of which waves the contour of a slice is made: an ellipse has two, a triangle with round corners three."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dashboard.content.ring import FULL_CIRCLE_DEG, Ring

ORDERS: Final = (2, 3, 4, 5, 6)
"""Waves around the circumference that are told."""

LEAST_FOR_CIRCLE: Final = 3

WORST_INFLATION: Final = 2.0
"""A wave is told where gaps make its amplitude at most so many times less certain than a whole ring would."""


@dataclass(frozen=True, slots=True)
class Harmonic:
    """A wave of the radius; ``amplitude_m`` is None where gaps do not let it be told.

    ``azimuth_deg`` is the first direction, clockwise from grid north, in which the radius is largest.
    """

    order: int
    amplitude_m: float | None
    azimuth_deg: float | None
    sigma_m: float | None


def harmonics_of(ring: Ring) -> tuple[Harmonic, ...]:
    """Fit waves of the radius to the sectors of a ring that have points, by least squares.

    The wave of order 1, which is the centre being off, is fitted besides and not told. Where gaps leave too little for
    all orders, the higher ones are left out: their amplitudes are None, never 0, and what there is of them is in the sigmas
    of the lower ones.
    """
    for highest in range(ORDERS[-1], ORDERS[0] - 1, -1):
        found = _fit(ring, highest)
        if found is not None:
            return tuple(found) + tuple(_untold(order) for order in ORDERS if order > highest)
    return tuple(_untold(order) for order in ORDERS)


def middle_of(ring: Ring) -> NDArray[np.float64]:
    """East and north (2,) of the middle of a contour from where it is seen: an algebraic circle through its sectors.

    With fewer than three sectors there is none to be found, and it is where it is seen from.
    """
    azimuth, radial_m = np.radians(ring.azimuth_deg[ring.seen]), ring.radial_m[ring.seen]
    if len(azimuth) < LEAST_FOR_CIRCLE:
        return np.zeros(2)
    east_north = radial_m[:, None] * np.column_stack([np.sin(azimuth), np.cos(azimuth)])
    columns = np.column_stack([2.0 * east_north, np.ones(len(azimuth))])
    return np.asarray(np.linalg.lstsq(columns, radial_m**2, rcond=None)[0][:2])


def _untold(order: int) -> Harmonic:
    return Harmonic(order, None, None, None)


def _fit(ring: Ring, highest: int) -> list[Harmonic] | None:
    """Waves up to an order; None where the sectors do not carry them."""
    azimuth = np.radians(ring.azimuth_deg[ring.seen])
    columns = _columns(azimuth, highest, ring.sector_deg)
    freedom = len(azimuth) - columns.shape[1]
    if freedom < 1:
        return None
    values, vectors = np.linalg.eigh(columns.T @ columns)
    if values[0] <= 0.0:
        return None
    cofactors = np.asarray((vectors / values) @ vectors.T)
    # of a whole ring every amplitude has the cofactor 2 / s
    if np.max(np.diag(cofactors)[1:]) > WORST_INFLATION**2 * 2.0 / len(ring.seen):
        return None
    found = cofactors @ (columns.T @ ring.radial_m[ring.seen])
    left = ring.radial_m[ring.seen] - columns @ found
    sigma = float(np.sqrt(left @ left / freedom))
    return [_harmonic(order, found, cofactors, sigma) for order in ORDERS if order <= highest]


def _columns(azimuth: NDArray[np.float64], highest: int, sector_deg: float) -> NDArray[np.float64]:
    orders = np.arange(1, highest + 1)
    # the middle of a sector flattens a wave as a moving mean does
    flattened = np.sinc(orders * sector_deg / FULL_CIRCLE_DEG)
    waves = np.stack([np.cos(azimuth[:, None] * orders), np.sin(azimuth[:, None] * orders)], axis=2)
    waves *= flattened[:, None]
    return np.column_stack([np.ones(len(azimuth)), waves.reshape(len(azimuth), -1)])


def _harmonic(
    order: int, found: NDArray[np.float64], cofactors: NDArray[np.float64], sigma: float
) -> Harmonic:
    place = slice(2 * order - 1, 2 * order + 1)
    cosine, sine = found[place]
    amplitude = float(np.hypot(cosine, sine))
    azimuth = float(np.degrees(np.arctan2(sine, cosine)) / order % (FULL_CIRCLE_DEG / order))
    spread = sigma * float(np.sqrt(np.trace(cofactors[place, place]) / 2.0))
    return Harmonic(order, amplitude, azimuth, spread)
