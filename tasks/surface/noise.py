"""How much the points of each station scatter about the surface, looking straight and at grazing angles."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import mad_sigma
from tasks.surface.cells import SECTORS, SurfacePoints, sector_of
from tasks.surface.profile import ProfileTable

INCIDENCE_EDGES_DEG: Final = (25.0, 45.0, 60.0, 72.0)
"""Classes of directions, away from that in which the station stands."""

LEAST_IN_CLASS: Final = 100
"""Fewer points make no scale of their own: those of the station, or of all stations, are taken instead."""

MOST_OF_STATION: Final = 2.0
"""A class that scatters more than this many times the station's own scale holds strays (a ladder fills a sector), not the
wall; a wall that does scatter so much at grazing angles loses no more than some of its weight."""

OFFSET_SIGMAS: Final = 3.0

SMALLEST_SIGMA_RADII: Final = 1e-7
"""Noise of a perfect surface as a part of its radius: a zero would reject every point."""


def noise_by_direction(sample: SurfacePoints, table: ProfileTable, radius_m: float) -> NDArray[np.float64]:
    """Robust standard deviations (stations, SECTORS) of the points about a surface, metres.

    From the points themselves, not from the maker's figures: station by station, and by how far round the shaft from the
    station a point lies, because a beam that grazes the skin scatters otherwise across it.
    """
    look = table.look_at(sample.points_m)
    floor = SMALLEST_SIGMA_RADII * radius_m
    everything = max(mad_sigma(look.residual_m), floor)
    sigma = np.full((sample.n_stations, SECTORS), everything)
    sector = sector_of(look.direction)
    middles = np.exp(2j * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS)
    for station in range(sample.n_stations):
        own = np.flatnonzero(sample.station_index == station)
        if len(own) < LEAST_IN_CLASS:
            continue
        sigma_of_station = max(_scatter(look.residual_m[own]), floor)
        sigma[station] = sigma_of_station
        towards = look.direction[own].sum()
        classes = _incidence_class(middles, towards)
        of_point = classes[sector[own]]
        for number in range(len(INCIDENCE_EDGES_DEG) + 1):
            members = own[of_point == number]
            if len(members) >= LEAST_IN_CLASS:
                own_scale = min(_scatter(look.residual_m[members]), MOST_OF_STATION * sigma_of_station)
                sigma[station, classes == number] = max(own_scale, floor)
    return sigma


def noise_of_all(sample: SurfacePoints, table: ProfileTable, radius_m: float) -> NDArray[np.float64]:
    """The same (stations, SECTORS) with one scale for all points."""
    scale = mad_sigma(table.look_at(sample.points_m).residual_m)
    return np.full((sample.n_stations, SECTORS), max(scale, SMALLEST_SIGMA_RADII * radius_m))


def _scatter(residuals_m: NDArray[np.float64]) -> float:
    """Robust standard deviation about the median, because where a station stands a little off, that is no noise.

    A station that stands far off keeps its points: the median itself lies within ``OFFSET_SIGMAS``.
    """
    middle = float(np.median(residuals_m))
    return max(mad_sigma(residuals_m - middle), abs(middle) / OFFSET_SIGMAS)


def _incidence_class(directions: NDArray[np.complex128], towards: complex) -> NDArray[np.intp]:
    away_deg = np.degrees(np.abs(np.angle(directions * np.conj(towards))))
    return np.asarray(np.searchsorted(INCIDENCE_EDGES_DEG, away_deg))
