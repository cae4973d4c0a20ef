"""What a drawing holds, whatever the format: lines, circles, ellipses and points with their attributes, or a cloud."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

Position: TypeAlias = tuple[float, float, float]
"""East, north, up in the frame of the drawing [m]."""

Value: TypeAlias = bool | int | float | str | None

PIECE_POINTS: Final = 1_000_000


@dataclass(frozen=True, slots=True)
class DrawingFrame:
    """Where a drawing lies: the frame in which the campaign states its positions, with east first.

    ``origin_m`` is what the campaign subtracts before any work, as east, north, up; here it is added again. ``epsg`` is the
    code of the projected system, None where the frame is local. ``warning`` is what the user should know of it.
    """

    origin_m: Position = (0.0, 0.0, 0.0)
    epsg: int | None = None
    warning: str = ""

    @property
    def meaning(self) -> str:
        """What the coordinates are, for people."""
        place = f"EPSG:{self.epsg}" if self.epsg else "a local frame of the site"
        east, north, up = self.origin_m
        origin = (
            f"; origin_m of the campaign ({east:.15g}, {north:.15g}, {up:.15g}) is added"
            if any(self.origin_m)
            else ""
        )
        return f"x east, y north, z up in metres, {place}{origin}; heights are those of the campaign"

    def placed(self, east_m: float, north_m: float, up_m: float) -> Position:
        """A position of the site frame in the frame of the drawing."""
        east, north, up = self.origin_m
        return (east_m + east, north_m + north, up_m + up)


@dataclass(frozen=True, slots=True)
class Point:
    """A place."""

    at: Position


@dataclass(frozen=True, slots=True)
class Line:
    """A straight line from one place to another."""

    start: Position
    end: Position


@dataclass(frozen=True, slots=True)
class Circle:
    """A horizontal circle."""

    center: Position
    radius_m: float


@dataclass(frozen=True, slots=True)
class Ellipse:
    """A horizontal ellipse; ``azimuth_deg`` is that of the larger diameter, clockwise from north."""

    center: Position
    larger_m: float
    smaller_m: float
    azimuth_deg: float


Shape: TypeAlias = Point | Line | Circle | Ellipse


@dataclass(frozen=True, slots=True)
class Feature:
    """A shape, what it shows (its layer), a short label for beside it, and what is known of it."""

    layer: str
    shape: Shape
    attributes: Mapping[str, Value]
    label: str = ""


@dataclass(frozen=True, slots=True)
class Drawing:
    """Shapes of one epoch of a structure."""

    what: str
    structure: str
    epoch: str
    epoch_time: datetime
    frame: DrawingFrame
    features: Sequence[Feature]


@dataclass(frozen=True, slots=True)
class DrawnCloud:
    """Points (n, 3) of one epoch in the site frame, each with the place (n,) of its station in ``stations``."""

    structure: str
    epoch: str
    epoch_time: datetime
    frame: DrawingFrame
    stations: Sequence[str]
    points_m: NDArray[np.float64]
    station_index: NDArray[np.integer]

    def pieces(self) -> Iterator[tuple[NDArray[np.float64], NDArray[np.int64]]]:
        """Give the points piece by piece in the frame of the drawing, (m, 3), with the places (m,) of their stations."""
        for start in range(0, len(self.points_m), PIECE_POINTS):
            rows = slice(start, start + PIECE_POINTS)
            yield (
                self.points_m[rows] + np.array(self.frame.origin_m),
                self.station_index[rows].astype(np.int64),
            )
