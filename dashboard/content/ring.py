"""The contour of a slice as its points show it, sector by sector, whatever was fitted to it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

SECTOR_WIDTHS_DEG: Final = (2.0, 5.0, 10.0)
"""Widths that a contour is drawn with: they divide the circle, and are those of maps and coverage or finer."""

POINTS_PER_SECTOR: Final = 12.0
"""So many points, on average, make the median of a sector worth drawing."""

LEAST_FOR_SIGMA: Final = 5
"""With fewer points a sector does not tell its own scatter."""

LEAST_FOR_RANGE: Final = 2
"""A range of one sector would be 0, whatever the wall is."""

MAD_TO_SIGMA: Final = 1.4826
MEDIAN_LOSS: Final = 1.2533
"""Standard deviation of a median over that of a mean, for normal scatter: the root of pi / 2."""

FULL_CIRCLE_DEG: Final = 360.0


@dataclass(frozen=True, slots=True)
class Arc:
    """A part of the circumference, clockwise from ``from_deg``; a gap over north ends beyond 360."""

    from_deg: float
    to_deg: float

    @property
    def width_deg(self) -> float:
        """How long it is."""
        return self.to_deg - self.from_deg


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """What the points of a slice are off a circle, by sector, clockwise from grid north.

    Attributes
    ----------
    radius_m : float
        Radius of the circle that deviations are counted from.
    sector_deg : float
        Width of a sector.
    n_points : (s,) array
        Points of every sector.
    radial_m : (s,) array
        Median distance of the points of a sector from the centre; NaN where there are none.
    sigma_m : (s,) array
        Standard deviation of that median from the scatter of its points; NaN below ``LEAST_FOR_SIGMA`` points.
    """

    radius_m: float
    sector_deg: float
    n_points: NDArray[np.int64]
    radial_m: NDArray[np.float64]
    sigma_m: NDArray[np.float64]

    @property
    def azimuth_deg(self) -> NDArray[np.float64]:
        """Middles (s,) of the sectors."""
        return np.asarray(self.sector_deg * (np.arange(len(self.radial_m)) + 0.5))

    @property
    def deviation_m(self) -> NDArray[np.float64]:
        """How far the contour (s,) is outside of the circle; NaN without points."""
        return np.asarray(self.radial_m - self.radius_m)

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which sectors (s,) have points."""
        return self.n_points > 0

    @property
    def coverage_deg(self) -> float:
        """Circumference that has points."""
        return float(self.seen.sum() * self.sector_deg)

    @property
    def gaps(self) -> tuple[Arc, ...]:
        """Parts without points, clockwise; none where all or no sectors have some."""
        first = np.flatnonzero(self.seen & ~np.roll(self.seen, -1)) + 1
        return tuple(self._gap_from(int(start)) for start in first)

    @property
    def range_m(self) -> float | None:
        """Largest minus smallest median of a sector; with gaps the section may have more. None of fewer than two."""
        if self.seen.sum() < LEAST_FOR_RANGE:
            return None
        return float(np.nanmax(self.radial_m) - np.nanmin(self.radial_m))

    def _gap_from(self, start: int) -> Arc:
        ahead = np.roll(self.seen, -start)
        width = int(np.argmax(ahead))
        begin = start % len(self.seen)
        return Arc(begin * self.sector_deg, (begin + width) * self.sector_deg)


@dataclass(frozen=True, slots=True, eq=False)
class Polar:
    """Points about the centre of a slice: azimuth (n,), clockwise from grid north, and distance (n,), metres."""

    azimuth_deg: NDArray[np.float64]
    radial_m: NDArray[np.float64]

    def thinned(self, most: int) -> "Polar":
        """Every k-th point, so that at most ``most`` are left."""
        step = max(1, -(-len(self.radial_m) // most))
        return Polar(self.azimuth_deg[::step], self.radial_m[::step])


@dataclass(frozen=True, slots=True, eq=False)
class SeenFrom:
    """Where a slice is seen from, and how the shaft changes over its thickness.

    ``centre_m`` (2,) is the centre at height ``z_m``; ``lean`` (2,) is its shift to the east and north per metre of
    height, ``taper`` that of the radius.
    """

    centre_m: NDArray[np.float64]
    z_m: float
    lean: NDArray[np.float64]
    taper: float


def polar_of(points_m: NDArray[np.float64], seen: SeenFrom) -> Polar:
    """See points (n, 3) of a slice from its centre, all brought to its middle height along the wall."""
    above_m = points_m[:, 2:] - seen.z_m
    out_m = points_m[:, :2] - seen.centre_m - above_m * seen.lean
    azimuth = np.degrees(np.arctan2(out_m[:, 0], out_m[:, 1])) % FULL_CIRCLE_DEG
    # the remainder of a tiny negative angle rounds to the full circle
    radial_m = np.hypot(out_m[:, 0], out_m[:, 1]) - seen.taper * above_m[:, 0]
    return Polar(np.where(azimuth >= FULL_CIRCLE_DEG, 0.0, azimuth), radial_m)


def sector_width_deg(n_points: int) -> float:
    """Width of sectors, the finest that gives them ``POINTS_PER_SECTOR`` on average; the widest for few points."""
    for width in SECTOR_WIDTHS_DEG:
        if n_points * width >= POINTS_PER_SECTOR * FULL_CIRCLE_DEG:
            return width
    return SECTOR_WIDTHS_DEG[-1]


def ring_of(points: Polar, radius_m: float | None, sector_deg: float) -> Ring:
    """Take the median distance of the points of every sector.

    Parameters
    ----------
    points : Polar
        The points of a slice.
    radius_m : float or None
        The fitted radius; None for the median of the sectors, where no contour was fitted.
    sector_deg : float
        Width of a sector; divides the circle.
    """
    n_sectors = round(FULL_CIRCLE_DEG / sector_deg)
    sector = np.minimum((points.azimuth_deg / sector_deg).astype(np.int64), n_sectors - 1)
    n_points = np.bincount(sector, minlength=n_sectors)
    groups = np.split(points.radial_m[np.argsort(sector, kind="stable")], np.cumsum(n_points)[:-1])
    radial_m = np.array([np.median(group) if len(group) else np.nan for group in groups])
    sigma_m = np.array([_sigma_of_median(group) for group in groups])
    if radius_m is None:
        radius_m = float(np.median(radial_m[n_points > 0])) if len(points.radial_m) else float("nan")
    return Ring(radius_m, sector_deg, n_points, radial_m, sigma_m)


def _sigma_of_median(values: NDArray[np.float64]) -> float:
    if len(values) < LEAST_FOR_SIGMA:
        return float("nan")
    scale = MAD_TO_SIGMA * float(np.median(np.abs(values - np.median(values))))
    return MEDIAN_LOSS * scale / float(np.sqrt(len(values)))
