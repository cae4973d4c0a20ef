"""Simulated shafts for the whole-surface fits: points on the skin, seen from stations around, with a known axis."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tasks.surface import StationPoses, SurfacePoints, SurfaceRequest, SurfaceStart
from tasks.surface.surface_fit import Sections

LOW_M, HIGH_M = 2.0, 102.0
LEAN = np.array([0.0073, -0.0057])
ARCSEC = np.pi / 648000

Curve = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def round_wall(z_m: NDArray[np.float64], turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """No deviation from a round section."""
    return np.zeros(np.broadcast(z_m, turn).shape)


def no_bend(z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """An axis that is straight."""
    return np.zeros((len(z_m), 2))


@dataclass(frozen=True)
class Shaft:
    """A shaft; ``wall(z, t)`` is what its skin is off the circle, ``bend(z)`` what its axis is off the line."""

    points: int = 12_000
    stations: int = 8
    sigma_m: float = 0.015
    lean: tuple[float, float] = (float(LEAN[0]), float(LEAN[1]))
    taper: float = -0.019
    half_view_rad: float = 1.4
    arc_deg: float = 360.0
    wall: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]] = round_wall
    bend: Curve = no_bend
    density: float = 0.0
    """How many more points the lower half has, as a share of the upper one's."""


def positions(stations: int) -> NDArray[np.float64]:
    """Stations (s, 3) evenly around, 250 m away."""
    turn = 2 * np.pi * np.arange(stations) / stations
    return np.column_stack([250 * np.cos(turn), 250 * np.sin(turn), np.full(stations, 1.6)])


def stations_of(stations: int, pose_covariance: NDArray[np.float64] | None = None) -> StationPoses:
    """The stations with poses that are exact, or as good as stated."""
    if pose_covariance is None:
        pose_covariance = 1e-20 * np.eye(6 * stations)
    return StationPoses(positions(stations), pose_covariance)


def scanned(shaft: Shaft, seed: int) -> SurfacePoints:
    """Points of a shaft with radial noise; each station sees its side, or all see one arc."""
    rng = np.random.default_rng(seed)
    share = rng.uniform(0, 1, shaft.points)
    share = np.where(rng.uniform(0, 1, shaft.points) < shaft.density, 0.5 * share, share)
    z = LOW_M + (HIGH_M - LOW_M) * share
    station = rng.integers(0, shaft.stations, shaft.points)
    if shaft.arc_deg < 360.0:
        turn = np.radians(rng.uniform(-0.5, 0.5, shaft.points) * shaft.arc_deg)
    else:
        view = rng.uniform(-shaft.half_view_rad, shaft.half_view_rad, shaft.points)
        turn = 2 * np.pi * station / shaft.stations + view
    radius = 4.6 + shaft.taper * (z - LOW_M) + shaft.wall(z, turn)
    radius += shaft.sigma_m * rng.standard_normal(shaft.points)
    axis = np.outer(z, shaft.lean) + shaft.bend(z)
    xy = axis + radius[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    return SurfacePoints(np.column_stack([xy, z]), station.astype(np.uint16), shaft.stations)


def start_of(shaft: Shaft, off_m: float = 0.003) -> SurfaceStart:
    """A rough shaft, millimetres off."""
    z = np.linspace(LOW_M, HIGH_M, 29)
    axis = np.outer(z, shaft.lean)
    return SurfaceStart(
        z, axis[:, 0] + off_m, axis[:, 1] - off_m, 4.6 + shaft.taper * (z - LOW_M) + off_m, (LOW_M, HIGH_M)
    )


def request_of(cloud: SurfacePoints, shaft: Shaft, sections: Sections = "horizontal") -> SurfaceRequest:
    """What the fit is asked with."""
    return SurfaceRequest(cloud, start_of(shaft), sections, stations_of(cloud.n_stations))


def turned(request: SurfaceRequest, points_m: NDArray[np.float64]) -> SurfaceRequest:
    """The same question with other points."""
    return replace(request, cloud=replace(request.cloud, points_m=points_m))
