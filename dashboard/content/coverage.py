"""Which parts of the shaft were seen: a grid of height bands and sectors, and its gaps."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from storage.records import CoverageRow


@dataclass(frozen=True, slots=True)
class CoverageGrid:
    """The shaft unrolled, from the bottom and clockwise from grid north.

    ``heights_m`` (n + 1) and ``azimuths_deg`` (m + 1) are the edges; ``points`` and ``stations`` (n, m) are NaN where
    there is no row; ``first`` (n, m) names the station with the most points, empty where none has any.
    """

    heights_m: NDArray[np.float64]
    azimuths_deg: NDArray[np.float64]
    points: NDArray[np.float64]
    stations: NDArray[np.float64]
    first: NDArray[np.str_]


@dataclass(frozen=True, slots=True)
class Gap:
    """Height bands that follow each other and lack the same sectors.

    ``sectors`` are the ends of what is lacking, degrees clockwise from grid north; one that goes through north ends
    beyond 360.
    """

    z_low_m: float
    z_high_m: float
    lacking_deg: float
    sectors: tuple[tuple[float, float], ...]


def coverage_grid(rows: Sequence[CoverageRow]) -> CoverageGrid:
    """Put the rows of an epoch into a grid; there must be one or more."""
    heights = np.unique([edge for row in rows for edge in (row.z_low_m, row.z_high_m)])
    azimuths = np.unique([edge for row in rows for edge in (row.azimuth_low_deg, row.azimuth_high_deg)])
    shape = (len(heights) - 1, len(azimuths) - 1)
    points, stations = np.full(shape, np.nan), np.full(shape, np.nan)
    first = np.full(shape, "", dtype=object)
    for row in rows:
        place = np.searchsorted(heights, row.z_low_m), np.searchsorted(azimuths, row.azimuth_low_deg)
        points[place], stations[place], first[place] = row.n_points, row.n_stations, row.station or ""
    return CoverageGrid(heights, azimuths, points, stations, first.astype(str))


def gaps(rows: Sequence[CoverageRow]) -> list[Gap]:
    """What was not seen at all, from the bottom."""
    empty: dict[tuple[float, float], list[tuple[float, float]]] = {}
    for row in sorted(rows, key=lambda row: (row.z_low_m, row.azimuth_low_deg)):
        sectors = empty.setdefault((row.z_low_m, row.z_high_m), [])
        if row.n_points == 0:
            sectors.append((row.azimuth_low_deg, row.azimuth_high_deg))
    found: list[Gap] = []
    for (low, high), sectors in empty.items():
        if not sectors:
            continue
        joined = _joined(sectors)
        goes_on = bool(found) and found[-1].z_high_m == low and found[-1].sectors == joined
        begin = found.pop().z_low_m if goes_on else low
        found.append(Gap(begin, high, sum(end - start for start, end in joined), joined))
    return found


def _joined(sectors: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Sectors that touch as one; that before north goes on with that behind it."""
    starts = [sectors[0], *(after for before, after in pairwise(sectors) if before[1] != after[0])]
    ends = [*(before for before, after in pairwise(sectors) if before[1] != after[0]), sectors[-1]]
    joined = [(begin[0], end[1]) for begin, end in zip(starts, ends, strict=True)]
    if len(joined) > 1 and joined[0][0] == 0.0 and joined[-1][1] == 360.0:
        joined[-1] = (joined[-1][0], 360.0 + joined.pop(0)[1])
    return tuple(joined)
