"""How much of the shaft was seen: points by height band, sector of azimuth and station."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from storage.records import CoverageCell
from tasks.preprocessing import ShaftModel

BAND_M: Final = 5.0
"""Height of a band; the last one of a shaft may be shorter."""

SHORTEST_M: Final = 1.0
"""What remains below this belongs to the band before: a band of a centimetre would be seen by nobody."""

SECTOR_DEG: Final = 10.0

SECTORS: Final = 36

_SECTOR_OF: Final = np.arange(2 * SECTORS) % SECTORS
"""Sector by the count of whole sectors since grid north of one turn before: no remainder for every point."""

CHUNK: Final = 65_536
"""Points that are worked on at once: what is made of them on the way stays in the processor's cache."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """What the stations of an epoch saw of the shaft.

    ``z_edges_m`` (b + 1,) are the ends of the height bands. ``counts`` (b, SECTORS, n) are the points by band, sector
    (the first begins at grid north, clockwise about the axis) and station; ``off_sum_m`` (b, SECTORS) is the sum of
    their distances from the surface of the model, positive outward, metres.
    """

    z_edges_m: NDArray[np.float64]
    counts: NDArray[np.int64]
    off_sum_m: NDArray[np.float64]

    @property
    def points(self) -> NDArray[np.int64]:
        """Points (b, SECTORS) of all stations together."""
        return np.asarray(self.counts.sum(axis=2))

    @property
    def covered_deg(self) -> float:
        """Circumference with points, degrees, mean over the bands by their height."""
        height_m = np.diff(self.z_edges_m)
        return float(SECTOR_DEG * (self.points > 0).sum(axis=1) @ height_m / height_m.sum())


def count_coverage(
    points_m: NDArray[np.float64],
    station_index: NDArray[np.integer],
    model: ShaftModel,
    shaft_z_m: tuple[float, float],
    n_stations: int,
) -> Coverage:
    """Count the shaft's points by height band, sector and station.

    Parameters
    ----------
    points_m : (n, 3) array
        Points of the isolated shaft, site frame, metres; those outside ``shaft_z_m`` do not count.
    station_index : (n,) array
        Which of the ``n_stations`` saw each.
    model : ShaftModel
        Says where the axis and the surface are.
    shaft_z_m : (float, float)
        Heights between which the bands lie.

    Raises
    ------
    ShapeError
        If shapes disagree, a station index is out of range, or the heights do not rise.
    """
    if points_m.ndim != 2 or points_m.shape[1] != 3 or station_index.shape != (len(points_m),):
        raise ShapeError(
            f"count_coverage needs points (n, 3) and a station each; got {points_m.shape} and {station_index.shape}"
        )
    if len(station_index) and not 0 <= int(station_index.min()) <= int(station_index.max()) < n_stations:
        raise ShapeError(
            f"count_coverage needs station indices below {n_stations}; got {station_index.max()}"
        )
    edges_m = band_edges_m(shaft_z_m)
    shape = (len(edges_m) - 1, SECTORS, n_stations)
    counts = np.zeros(np.prod(shape), dtype=np.int64)
    off_sum_m = np.zeros(shape[0] * SECTORS)
    profile = _profile(model, edges_m[0], edges_m[-1])
    for start in range(0, len(points_m), CHUNK):
        rows = slice(start, start + CHUNK)
        cell, inside, off_m = _cells_of(points_m[rows], profile, shape[0])
        counts += np.bincount(cell * n_stations + station_index[rows][inside], minlength=len(counts))
        off_sum_m += np.bincount(cell, weights=off_m, minlength=len(off_sum_m))
    return Coverage(edges_m, counts.reshape(shape), off_sum_m.reshape(shape[:2]))


def band_edges_m(shaft_z_m: tuple[float, float]) -> NDArray[np.float64]:
    """Ends (b + 1,) of bands of BAND_M from the lower height on; the last one ends at the upper height.

    The last one is from SHORTEST_M to BAND_M + SHORTEST_M high, or as high as the shaft.

    Raises
    ------
    ShapeError
        If the heights do not rise.
    """
    low, high = shaft_z_m
    if not low < high:
        raise ShapeError(f"bands need heights that rise; got {shaft_z_m}")
    n = max(int(np.ceil((high - low - SHORTEST_M) / BAND_M)), 1)
    return np.append(low + BAND_M * np.arange(n), high)


def coverage_cells(coverage: Coverage, stations: Sequence[str]) -> tuple[CoverageCell, ...]:
    """One row a band and sector, from the bottom, clockwise from north; those without points too.

    Raises
    ------
    ShapeError
        If there are not as many station ids as were counted.
    """
    if len(stations) != coverage.counts.shape[2]:
        raise ShapeError(f"coverage of {coverage.counts.shape[2]} stations; got {len(stations)} ids")
    bands = list(pairwise(coverage.z_edges_m.tolist()))
    return tuple(
        _cell(coverage, stations, band, (b, sector))
        for b, band in enumerate(bands)
        for sector in range(SECTORS)
    )


@dataclass(frozen=True, slots=True)
class _Profile:
    """The axis and radius of a shaft between two heights, ready for many points: linear between knots."""

    knots_z_m: NDArray[np.float64]
    values_m: NDArray[np.float64]
    """East and north of the axis and radius (3, k) at the knots."""
    model: ShaftModel

    def at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """East, north and radius (3, n) at heights (n,); looks a height up once, where the model does thrice."""
        place = np.interp(z_m, self.knots_z_m, np.arange(len(self.knots_z_m)))
        knot = np.minimum(place.astype(np.intp), len(self.knots_z_m) - 2)
        part = place - knot
        step_m = np.diff(self.values_m, axis=1)
        return np.stack([v[knot] + part * s[knot] for v, s in zip(self.values_m, step_m, strict=True)])


def _profile(model: ShaftModel, low_m: float, high_m: float) -> _Profile:
    knots = np.array(model.radius_z_m)
    # with the ends among the knots nothing bends between two of them, not where the model ends either
    knots = np.concatenate([[low_m], knots[(knots > low_m) & (knots < high_m)], [high_m]])
    return _Profile(knots, np.vstack([model.axis_at(knots).T, model.radius_at(knots)]), model)


def _cells_of(
    points_m: NDArray[np.float64], profile: _Profile, n_bands: int
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64]]:
    """Cell (k,) of the points within the bands, their rows (k,), and how far each is off the surface (k,)."""
    low_m, high_m = profile.knots_z_m[[0, -1]]
    inside = np.flatnonzero((points_m[:, 2] >= low_m) & (points_m[:, 2] <= high_m))
    east, north, z = points_m.T if len(inside) == len(points_m) else points_m[inside].T
    axis_east, axis_north, radius = profile.at(z)
    east, north = east - axis_east, north - axis_north
    # a point on the edge of two bands belongs to the upper one, at the very top to the last
    band = np.minimum(((z - low_m) / BAND_M).astype(np.intp), n_bands - 1)
    turns = np.arctan2(east, north) / (2.0 * np.pi)
    sector = _SECTOR_OF[((turns + 1.0) * SECTORS).astype(np.intp)]
    if profile.model.is_round:
        off_m = np.sqrt(east * east + north * north) - radius
    else:
        off_m = profile.model.off_surface_m(points_m[inside])
    return band * SECTORS + sector, inside, off_m


def _cell(
    coverage: Coverage, stations: Sequence[str], band: tuple[float, float], place: tuple[int, int]
) -> CoverageCell:
    seen = coverage.counts[place]
    n_points = int(seen.sum())
    return CoverageCell(
        z_low_m=band[0],
        z_high_m=band[1],
        azimuth_low_deg=SECTOR_DEG * place[1],
        azimuth_high_deg=SECTOR_DEG * (place[1] + 1),
        n_points=n_points,
        n_stations=int(np.count_nonzero(seen)),
        station=stations[int(np.argmax(seen))] if n_points else None,
        off_surface_m=float(coverage.off_sum_m[place]) / n_points if n_points else None,
    )
