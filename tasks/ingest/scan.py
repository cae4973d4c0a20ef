"""What a scan is, what is asked of it, and what a reader must offer."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from storage.integer_grid import IntegerGrid

Coordinates = Literal["cartesian", "polar"]
LengthUnit = Literal["metre", "foot", "US survey foot"]
Frame = Literal["scanner", "file"]
Levelling = Literal["scanner", "file"]

METRES_PER_UNIT: Final[Mapping[LengthUnit, float]] = MappingProxyType(
    {"metre": 1.0, "foot": 0.3048, "US survey foot": 1200.0 / 3937.0}
)

COLUMN_NAMES: Final[Mapping[Coordinates, tuple[str, str, str]]] = MappingProxyType(
    {"cartesian": ("x", "y", "z"), "polar": ("s", "alpha", "omega")}
)
"""Names of the three columns, lower case."""


@dataclass(frozen=True, slots=True)
class FilePose:
    """Pose of a scan as its file states it: ``points_file = rotation @ points_scanner + translation``.

    ``rotation`` (3, 3) is a proper rotation, ``translation`` (3,) is in the unit of the file.
    """

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ScanPart:
    """One scan of a file that may hold several; ``name`` and ``pose`` are None where the file states none."""

    name: str | None
    n_points: int
    pose: FilePose | None


@dataclass(frozen=True, slots=True)
class ScanRequest:
    """What the campaign file says about a scan.

    ``frame`` "scanner" asks for one scan in the frame of its scanner: ``part`` says which, by its name or its number
    from 1, and may be None only where the file holds one. "file" asks for the scans of the file (all, or ``part``)
    joined, each placed by its own pose. ``horizontal`` is the coordinate system that the campaign states for a cloud in
    the frame of the file: with "EPSG:n" a file that states another one is refused, with "local" one that states any
    is noted, with None nothing is compared. No points are turned or moved by it.

    ``origin_m`` is subtracted first, in the axes of the file; ``swap_axes`` then turns north, east, up into
    east, north, up. A station's cloud in its scanner frame has neither. ``unit`` is what the campaign states
    for the file; a file whose own coordinate system states another one is refused.

    ``levelling`` "scanner" takes the z axis of a scan in its scanner frame as plumb. "file" turns the points by the
    tilt that the file's pose states, so that the pose that is left is a heading and a shift; a file that states no pose
    is refused.
    """

    coordinates: Coordinates = "cartesian"
    origin_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    swap_axes: bool = False
    unit: LengthUnit = "metre"
    frame: Frame = "scanner"
    part: str | int | None = None
    horizontal: str | None = None
    levelling: Levelling = "scanner"


@dataclass(frozen=True, slots=True)
class Scan:
    """The points of one file, checked.

    ``points_m`` is an (n, 3) C-contiguous float64 array: scanner frame, or site frame for a registered cloud.
    ``n_in_file`` counts the records of the file; those without a return are in it, but not in ``points_m``.
    ``notes`` are warnings worth telling, each a lower-case clause without the file's name.
    ``pose`` is that of the scan in its file, in metres, where the file states one and the scan is in its own frame.
    """

    points_m: NDArray[np.float64]
    n_in_file: int
    notes: tuple[str, ...] = ()
    pose: FilePose | None = None


@dataclass(frozen=True, slots=True)
class ScanFacts:
    """What is known of a scan when its last point has gone by: as in ``Scan``."""

    n_in_file: int
    notes: tuple[str, ...]
    pose: FilePose | None


@dataclass(frozen=True, slots=True)
class ScanStream:
    """The points of one file, checked, in pieces.

    ``pieces`` gives them in order, to be gone through once, each good until the next is asked for: int32 (m, 3) of which
    ``grid`` makes metres, or float64 (m, 3), metres, where there is no grid. It raises what ``read_scan`` does, much of it
    after the last piece: points are good only when it came to its end. It hands the facts to the function that it is given
    just before.
    """

    grid: IntegerGrid | None
    pieces: Callable[[Callable[[ScanFacts], None]], Iterator[NDArray[Any]]]


@dataclass(frozen=True, slots=True)
class Bounds:
    """Corners of a box, (3,) each; that of a header is as in the file: no origin off, no axes swapped."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]


def box_of(values: NDArray[Any]) -> Bounds:
    """Box around records (n, 3); column by column, which is ten times faster than ``min(axis=0)``."""
    columns = values.T
    return Bounds(
        np.array([column.min() for column in columns]), np.array([column.max() for column in columns])
    )


@dataclass(frozen=True, slots=True)
class ScanHeader:
    """What can be said of a file without reading its points; ``n_points`` is None where only reading tells.

    ``parts`` are the scans of a format that can hold several; empty where a file is one cloud. ``horizontal`` is the
    projected coordinate system that the file states, "EPSG:n" or its name in quotes.
    """

    format: str
    n_points: int | None
    size_bytes: int
    bounds: Bounds | None
    parts: tuple[ScanPart, ...] = ()
    horizontal: str | None = None


@dataclass(frozen=True, slots=True)
class RawScan:
    """The records of a file as they stand in it.

    ``values`` is (n, 3): x, y, z, or range, horizontal angle and elevation in degrees.
    ``step`` is the coarsest step in which the file can store a coordinate, in its own unit, where it says so.
    ``pose`` is that of the one scan that was asked for in its own frame, where the file states one.
    """

    values: NDArray[np.float64]
    step: float | None = None
    notes: tuple[str, ...] = ()
    pose: FilePose | None = None


class Watch(Protocol):
    """What a format has to say of its own records, looked at as they go by."""

    def see(self, integers: NDArray[np.int32], box: Bounds) -> None:
        """Look at the next records (m, 3), and the box around them in integers."""

    def notes(self) -> tuple[str, ...]:
        """Say what was found, after the last."""


@dataclass(frozen=True, slots=True)
class RawStream:
    """The records of a file as they stand in it, integers (m, 3) for x, y, z, in pieces.

    ``grid`` makes coordinates of them in the unit of the file. ``decode`` begins anew with every call, and gives all
    ``n_points`` records or raises InputError; a piece is overwritten by the next. ``watch`` is for one pass.
    """

    n_points: int
    grid: IntegerGrid
    decode: Callable[[], Iterator[NDArray[np.int32]]]
    watch: Watch
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Reader:
    """A file format: one file in this folder with a module-level ``READER``.

    ``suffixes`` are lower case with the dot. ``describe`` reads headers only. ``read`` returns every record that
    the file claims, or raises InputError; it never returns fewer. ``stream`` gives Cartesian coordinates piece by piece,
    where the format can; ``read`` is then asked for polar ones alone.
    """

    name: str
    suffixes: tuple[str, ...]
    describe: Callable[[Path, ScanRequest], ScanHeader]
    read: Callable[[Path, ScanRequest], RawScan]
    stream: Callable[[Path, ScanRequest], RawStream] | None = None
