"""What stands beside the points of a shaft in three dimensions: axis, plumb line, rings of slices, stations."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from dashboard.content.cloud import StraightLine
from dashboard.content.section import FLAT
from storage.records import SliceRow, StationRow, TiltRow
from storage.views.shaft_points import ShaftPoints

FOOT_POINTS: Final = 2000
"""Without an axis the foot is the middle of so many of the lowest points."""


@dataclass(frozen=True, slots=True)
class RingLine:
    """A slice with a round contour: its centre and height from the origin, its radius, metres."""

    index: int
    east_m: float
    north_m: float
    up_m: float
    radius_m: float


@dataclass(frozen=True, slots=True)
class StationPin:
    """Where a scanner stood, from the origin, metres; ``place`` is that of the points, None where it has none."""

    station: str
    state: str
    east_m: float
    north_m: float
    up_m: float
    place: int | None


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Everything but the points.

    The origin (3,), site frame, is the foot: the axis at the height of the lowest point. The plumb line goes up from it.
    """

    origin_m: NDArray[np.float64]
    top_m: float
    """Height of the highest point above the origin."""
    axis: StraightLine
    has_axis: bool
    rings: tuple[RingLine, ...]
    stations: tuple[StationPin, ...]


def scene_of(
    points: ShaftPoints, tilt: TiltRow | None, slices: Sequence[SliceRow], stations: Sequence[StationRow]
) -> Scene:
    """Put a scene together about the foot of the shaft; without an axis it is upright in the middle of its lowest points."""
    low_m, high_m = float(points.points_m[0, 2]), float(points.points_m[-1, 2])
    axis = _axis_of(points, tilt)
    origin_m = np.append(axis.at(np.array(low_m)), low_m)
    return Scene(
        origin_m=origin_m,
        top_m=high_m - low_m,
        axis=axis,
        has_axis=tilt is not None,
        rings=tuple(_rings(slices, origin_m)),
        stations=tuple(_pins(stations, points.stations, origin_m)),
    )


def _axis_of(points: ShaftPoints, tilt: TiltRow | None) -> StraightLine:
    if tilt is None:
        middle = np.median(points.points_m[:FOOT_POINTS, :2], axis=0)
        return StraightLine(np.asarray(middle), np.zeros(2))
    return StraightLine(
        np.array([tilt.base_east_m, tilt.base_north_m]), np.array([tilt.lean_east, tilt.lean_north])
    )


def _rings(slices: Sequence[SliceRow], origin_m: NDArray[np.float64]) -> list[RingLine]:
    return [
        RingLine(
            row.slice_index,
            row.center_east_m - float(origin_m[0]),
            row.center_north_m - float(origin_m[1]),
            row.z_m - float(origin_m[2]),
            row.radius_m,
        )
        for row in slices
        # a circle is not the outline of flat faces
        if row.contour not in FLAT
        and row.center_east_m is not None
        and row.center_north_m is not None
        and row.radius_m is not None
    ]


def _pins(
    stations: Sequence[StationRow], used: Sequence[str], origin_m: NDArray[np.float64]
) -> list[StationPin]:
    east, north, up = origin_m
    return [
        StationPin(
            row.station,
            row.state,
            row.position_east_m - float(east),
            row.position_north_m - float(north),
            row.position_up_m - float(up),
            used.index(row.station) if row.station in used else None,
        )
        for row in stations
        if row.position_east_m is not None
        and row.position_north_m is not None
        and row.position_up_m is not None
    ]
