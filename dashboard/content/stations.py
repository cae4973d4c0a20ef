"""Where the stations stood as seen from the structure, and how well their scans fit."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from storage.records import StationRow

EastNorth = tuple[float, float]

WEAK: Final = {"shift east": (1.0, 0.0), "shift north": (0.0, 1.0)}
"""Directions in the plan by the words of ``weakest_direction``; others are no direction in the plan."""


@dataclass(frozen=True, slots=True)
class Pin:
    """A station on the map, metres in the site frame.

    ``distance_m`` and ``azimuth_deg`` (clockwise from grid north) are those of the station as seen from the foot of
    the axis; None without an axis. ``weak`` is the direction in the plan that the data know least.
    """

    station: str
    east_m: float
    north_m: float
    state: str
    reason: str | None
    rmse_m: float | None
    distance_m: float | None
    azimuth_deg: float | None
    weak: EastNorth | None


@dataclass(frozen=True, slots=True)
class StationMap:
    """The plan of an epoch. ``foot_m`` is None without an axis, ``radius_m`` without a slice.

    ``nowhere`` names stations without an adjusted position. ``next_deg`` is where one more station would help most, as
    seen from the foot.
    """

    pins: Sequence[Pin]
    nowhere: Sequence[str]
    foot_m: EastNorth | None
    radius_m: float | None
    next_deg: float | None

    @property
    def reach_m(self) -> float:
        """Distance from the foot of the farthest station."""
        return max((pin.distance_m for pin in self.pins if pin.distance_m is not None), default=0.0)


def station_map(
    stations: Sequence[StationRow], foot_m: EastNorth | None, radius_m: float | None, next_deg: float | None
) -> StationMap:
    """Put the stations that have an adjusted position on the map."""
    placed = [pin for row in stations if (pin := _pin(row, foot_m)) is not None]
    names = {pin.station for pin in placed}
    nowhere = [row.station for row in stations if row.station not in names]
    return StationMap(placed, nowhere, foot_m, radius_m, next_deg)


def _pin(row: StationRow, foot_m: EastNorth | None) -> Pin | None:
    if row.position_east_m is None or row.position_north_m is None:
        return None
    distance_m = azimuth_deg = None
    if foot_m is not None:
        east, north = row.position_east_m - foot_m[0], row.position_north_m - foot_m[1]
        distance_m, azimuth_deg = math.hypot(east, north), math.degrees(math.atan2(east, north)) % 360.0
    return Pin(
        row.station,
        row.position_east_m,
        row.position_north_m,
        row.state,
        row.reason,
        row.rmse_m,
        distance_m,
        azimuth_deg,
        WEAK.get(row.weakest_direction or ""),
    )
