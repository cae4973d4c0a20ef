"""The skin of a shaft, unrolled: a grid of height bands and sectors, and from where it was seen."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import StationRow, SurfaceMapRow, TiltRow
from storage.views import SurfaceChangeRow

USUAL_SHARE: Final = 0.98
"""Share of the pieces that a colour range holds: the largest of a few strays does not wash out the rest."""

RANGES_MM: Final = (1.0, 2.0, 3.0, 5.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0, 80.0, 100.0, 200.0, 500.0, 1000.0)


@dataclass(frozen=True, slots=True, eq=False)
class SkinGrid:
    """Where the pieces are: bands (b,) from the bottom, sectors (s,) clockwise from grid north."""

    z_low_m: NDArray[np.float64]
    z_high_m: NDArray[np.float64]
    azimuth_deg: NDArray[np.float64]

    @property
    def z_m(self) -> NDArray[np.float64]:
        """Middles (b,) of the bands."""
        return np.asarray((self.z_low_m + self.z_high_m) / 2.0)

    @property
    def z_edges_m(self) -> NDArray[np.float64]:
        """Ends (b + 1,) of the bands, which stand on one another."""
        return np.append(self.z_low_m, self.z_high_m[-1])

    @property
    def azimuth_edges_deg(self) -> NDArray[np.float64]:
        """Ends (s + 1,) of the sectors."""
        return np.linspace(0.0, 360.0, len(self.azimuth_deg) + 1)


@dataclass(frozen=True, slots=True, eq=False)
class SkinMap:
    """What pieces (b, s) are off a straight shaft, metres, positive outward; NaN where nothing was seen or told."""

    grid: SkinGrid
    deviation_m: NDArray[np.float64]
    sigma_m: NDArray[np.float64]
    """Points and poses together."""
    n_points: NDArray[np.int64]
    radius_m: NDArray[np.float64]
    """Of every band (b,)."""


@dataclass(frozen=True, slots=True, eq=False)
class SkinChange:
    """What pieces (b, s) moved since the reference epoch, metres, and the level of detection of each."""

    grid: SkinGrid
    reference_epoch: str
    change_m: NDArray[np.float64]
    lod_m: NDArray[np.float64]
    significant: NDArray[np.bool_]

    @property
    def n_significant(self) -> int:
        """Pieces beyond their level of detection."""
        return int(self.significant.sum())

    @property
    def n_compared(self) -> int:
        """Pieces that both epochs saw."""
        return int(np.isfinite(self.change_m).sum())


@dataclass(frozen=True, slots=True)
class StationMark:
    """In which direction a station stands, as seen from the axis."""

    station: str
    azimuth_deg: float
    distance_m: float


def skin_map(rows: Sequence[SurfaceMapRow]) -> SkinMap | None:
    """Lay the rows of a map into their grid; None where there are none."""
    if not rows:
        return None
    grid, shape = _grid_of(rows)
    spread = np.hypot(_table([row.deviation_sigma_m for row in rows], shape), _placing(rows, shape))
    return SkinMap(
        grid=grid,
        deviation_m=_table([row.deviation_m for row in rows], shape),
        sigma_m=spread,
        n_points=np.array([row.n_points for row in rows]).reshape(shape),
        radius_m=_table([row.radius_m for row in rows], shape)[:, 0],
    )


def skin_change(rows: Sequence[SurfaceChangeRow]) -> SkinChange | None:
    """Lay the rows of a difference into their grid; None where there are none."""
    if not rows:
        return None
    grid, shape = _grid_of(rows)
    return SkinChange(
        grid=grid,
        reference_epoch=rows[0].reference_epoch,
        change_m=_table([row.change_m for row in rows], shape),
        lod_m=_table([row.lod95_m for row in rows], shape),
        significant=np.array([bool(row.significant) for row in rows]).reshape(shape),
    )


def range_mm(*tables_m: NDArray[np.float64]) -> float:
    """The range of colours on both sides of 0 for tables of several epochs: one for all of them, a round number."""
    sizes = np.concatenate([np.abs(table[np.isfinite(table)]).ravel() for table in tables_m])
    usual_mm = 1e3 * float(np.quantile(sizes, USUAL_SHARE)) if len(sizes) else 0.0
    return next((size for size in RANGES_MM if size >= usual_mm), RANGES_MM[-1])


def station_marks(stations: Sequence[StationRow], tilt: TiltRow | None) -> list[StationMark]:
    """Directions of the stations that were used, as seen from the foot of the axis; none without an axis."""
    if tilt is None:
        return []
    marks = []
    for row in stations:
        if row.state != "failed" and row.position_east_m is not None and row.position_north_m is not None:
            east, north = row.position_east_m - tilt.base_east_m, row.position_north_m - tilt.base_north_m
            azimuth = math.degrees(math.atan2(east, north)) % 360.0
            marks.append(StationMark(row.station, azimuth, math.hypot(east, north)))
    return sorted(marks, key=lambda mark: mark.azimuth_deg)


def _grid_of(rows: Sequence[SurfaceMapRow] | Sequence[SurfaceChangeRow]) -> tuple[SkinGrid, tuple[int, int]]:
    """The grid of rows that come band after band."""
    n_sectors = len({row.azimuth_deg for row in rows})
    firsts = rows[::n_sectors]
    grid = SkinGrid(
        z_low_m=np.array([row.z_low_m for row in firsts]),
        z_high_m=np.array([row.z_high_m for row in firsts]),
        azimuth_deg=np.array([row.azimuth_deg for row in rows[:n_sectors]]),
    )
    return grid, (len(firsts), n_sectors)


def _table(values: Sequence[float | None], shape: tuple[int, int]) -> NDArray[np.float64]:
    return np.array(values, dtype=np.float64).reshape(shape)


def _placing(rows: Sequence[SurfaceMapRow], shape: tuple[int, int]) -> NDArray[np.float64]:
    return _table([row.placing_sigma_m for row in rows], shape)
