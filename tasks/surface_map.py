"""A map of the surface of a shaft: how far every piece is off a straight shaft, and off the designed shape."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from storage.records import SurfaceMapCell
from tasks.geometry.failure import FitFailure
from tasks.geometry.rows_between import rows_between
from tasks.map_cells import SECTORS, CellMeans, CellPoints, MapGrid, OfRows, map_grid, robust_means
from tasks.map_poses import PlacingSpread, SeenPieces, placing_spread
from tasks.map_shapes import (
    DesignedShape,
    StraightAxis,
    designed_shaft,
    distances_m,
    skin_of,
    straight_line,
    straight_shaft,
)
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.registration import Registration
from tasks.whole_surface import RoundCut

LEAST_SECTORS: Final = 3
"""Sectors with points that a band needs for a radius of its own: the median of fewer is that of a bulge."""


@dataclass(frozen=True, slots=True)
class MapQuestion:
    """Between which heights, which cut of the shaft is round, and the design or None."""

    shaft_z_m: tuple[float, float]
    sections: RoundCut
    design: DesignedShape | None


@dataclass(frozen=True, slots=True, eq=False)
class _Map:
    """Pieces that have points, ascending, with everything that is told of them."""

    grid: MapGrid
    means: CellMeans
    rings_m: NDArray[np.float64]
    """What the radius of every band (b,) is more than that of ``shaft``."""
    shaft: ShaftModel
    seen: NDArray[np.intp]
    spread: PlacingSpread
    design: "_OffDesign | None"


@dataclass(frozen=True, slots=True, eq=False)
class _OffDesign:
    """What all pieces (c,) are off the design, and what the poses do to that of those with points (k,), metres."""

    mean_m: NDArray[np.float64]
    placing_m: NDArray[np.float64]


def map_surface(
    cloud: PlacedCloud,
    model: ShaftModel,
    axis: StraightAxis,
    registration: Registration,
    question: MapQuestion,
) -> tuple[SurfaceMapCell, ...] | FitFailure:
    """Map what the points are off a straight shaft around a measured axis, and off the design.

    The radius of the straight shaft is that of the rough model, put right in every band by the median of its sectors:
    what a whole band has in common is ``radius_m``, the rest deviation. A bent axis or an oval section shows in the map.

    Parameters
    ----------
    cloud : PlacedCloud
        Points of the isolated shaft, with their stations in the order of the registration's poses.
    model : ShaftModel
        Rough radius, or faces.
    axis : StraightAxis
        The measured axis.
    registration : Registration
        Poses and their covariance.
    question : MapQuestion
        What is asked.

    Returns
    -------
    tuple of SurfaceMapCell or FitFailure
        From the bottom, clockwise from north, pieces without points too.

    Raises
    ------
    ShapeError
        If the design ends within the shaft, or the heights of the shaft do not rise.

    References
    ----------
    Deviations from the designed shape are those of reference [48] of Zhou et al. 2025.
    """
    grid = map_grid(question.shaft_z_m)
    low, high = question.shaft_z_m
    inside = rows_between(cloud.points_m[:, 2], low, high)
    points = PlacedCloud(cloud.points_m[inside], cloud.station_index[inside])
    if len(points.points_m) == 0:
        return FitFailure(f"needs points between {low:g} and {high:g} m, got none")
    found = _map(points, straight_shaft(model, axis, question.shaft_z_m), registration, question, grid)
    if isinstance(found, FitFailure):
        return found
    return tuple(_cell(found, number) for number in range(grid.size))


def _map(
    cloud: PlacedCloud, shaft: ShaftModel, registration: Registration, question: MapQuestion, grid: MapGrid
) -> _Map | FitFailure:
    def off(reference: ShaftModel) -> OfRows:
        return lambda rows: distances_m(cloud.points_m[rows], reference, question.sections)

    pieces = _pieces(cloud, shaft, grid, len(registration.poses))
    means = robust_means(off(shaft), pieces.cell, pieces.n_points)
    rings_m = _rings(grid, means)
    if isinstance(rings_m, FitFailure):
        return rings_m
    seen = np.flatnonzero(means.n_points)
    skin = skin_of(grid.z_m[grid.band[seen]], grid.azimuth_deg[seen], shaft)
    shown = SeenPieces(grid, seen, skin.points_m, skin.outward, pieces.shares[seen])
    spread = placing_spread(shown, registration, question.shaft_z_m[0])
    design = None
    if question.design is not None:
        designed = designed_shaft(shaft, question.design, question.shaft_z_m)
        off_m = means.mean_of(off(designed), off(shaft), pieces.cell)
        design = _OffDesign(off_m, spread.from_foot if question.design.base_xy_m is None else spread.fixed)
    return _Map(grid, means, rings_m, shaft, seen, spread, design)


def _rings(grid: MapGrid, means: CellMeans) -> NDArray[np.float64] | FitFailure:
    """Median deviation (b,) of the sectors of every band, between neighbours where a band has too few of them."""
    table, seen = means.mean.reshape(-1, SECTORS), means.n_points.reshape(-1, SECTORS) > 0
    known = seen.sum(axis=1) >= LEAST_SECTORS
    if not known.any():
        return FitFailure(f"needs a band with points in {LEAST_SECTORS} sectors, got none")
    medians = [np.median(table[band][seen[band]]) for band in np.flatnonzero(known)]
    return np.asarray(np.interp(grid.z_m, grid.z_m[known], medians))


def _pieces(cloud: PlacedCloud, shaft: ShaftModel, grid: MapGrid, n_stations: int) -> CellPoints:
    """Which points belong to which piece; they lie within the bands."""
    from tasks.geometry.sector_kernel import even_sectors  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)
    from tasks.map_kernel import find_pieces  # noqa: PLC0415 (as above)

    if int(cloud.station_index.max()) >= n_stations:
        raise ShapeError(f"a map needs station indices below {n_stations}; got {cloud.station_index.max()}")
    cell, counts = (
        np.empty(len(cloud.points_m), dtype=np.uint16),
        np.zeros((grid.size, n_stations), dtype=np.int64),
    )
    find_pieces(
        cloud.points_m,
        cloud.station_index,
        straight_line(shaft),
        grid.z_edges_m,
        even_sectors(SECTORS),
        cell,
        counts,
    )
    return CellPoints(cell, counts)


def _cell(found: _Map, number: int) -> SurfaceMapCell:
    grid, means = found.grid, found.means
    band = int(grid.band[number])
    z_m = float(grid.z_m[band])
    told = _told(found, number) if means.n_points[number] else _Told()
    return SurfaceMapCell(
        z_low_m=float(grid.z_edges_m[band]),
        z_high_m=float(grid.z_edges_m[band + 1]),
        z_m=z_m,
        azimuth_deg=float(grid.azimuth_deg[number]),
        n_points=int(means.n_points[number]),
        radius_m=float(found.shaft.radius_at(z_m) + found.rings_m[band]),
        deviation_m=told.deviation_m,
        deviation_sigma_m=told.deviation_sigma_m,
        placing_sigma_m=told.placing_sigma_m,
        design_deviation_m=told.design_deviation_m,
        design_sigma_m=told.design_sigma_m,
    )


@dataclass(frozen=True, slots=True)
class _Told:
    """What points tell of a piece; nothing where there are none."""

    deviation_m: float | None = None
    deviation_sigma_m: float | None = None
    placing_sigma_m: float | None = None
    design_deviation_m: float | None = None
    design_sigma_m: float | None = None


def _told(found: _Map, number: int) -> _Told:
    means, spread = found.means, found.spread
    place = int(np.searchsorted(found.seen, number))
    sigma = None if means.sigma is None else float(means.sigma[number])
    told = _Told(
        deviation_m=float(means.mean[number] - found.rings_m[found.grid.band[number]]),
        deviation_sigma_m=sigma,
        placing_sigma_m=float(spread.own[place]),
    )
    design = found.design
    if design is None:
        return told
    return replace(
        told,
        design_deviation_m=float(design.mean_m[number]),
        design_sigma_m=None if sigma is None else float(np.hypot(sigma, design.placing_m[place])),
    )
