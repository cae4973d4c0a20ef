"""What a station sees of the shaft: which cells, with how many points, and how well each measures."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.design.shaft import Cells

REFERENCE_RANGE_M: Final = 100.0
"""At this range the standard deviation of a range is stated; it grows with the range, and never falls below half."""


@dataclass(frozen=True, slots=True)
class Site:
    """Where a scanner is to stand: east, north, up in the site frame, metres."""

    station: str
    position_m: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Hidden:
    """A part of the shaft that something hides from a station, or from all where ``station`` is None.

    ``azimuth_deg`` is the sector of the surface from the first azimuth clockwise to the second, about the axis (all
    round where None); ``below_m`` the height under which it is hidden, site frame (all heights where None).
    """

    station: str | None = None
    azimuth_deg: tuple[float, float] | None = None
    below_m: float | None = None


@dataclass(frozen=True, slots=True)
class Scanning:
    """How a station scans: the step of its grid in both angles, and what it does not measure.

    A surface that the sight meets at an incidence above ``incidence_limit_rad`` (from the normal) gives no point, and
    none lies farther than ``reach_m``.
    """

    spacing_rad: float
    incidence_limit_rad: float = float(np.radians(80.0))
    reach_m: float = np.inf

    def __post_init__(self) -> None:
        if not (self.spacing_rad > 0.0 and 0.0 < self.incidence_limit_rad < np.pi / 2 and self.reach_m > 0.0):
            raise ShapeError(f"scanning needs a spacing, a reach and a limit below 90 degrees; got {self!r}")


Levels = Literal["held", "adjusted"]


@dataclass(frozen=True, slots=True)
class Errors:
    """Standard deviations of what goes wrong; 0 is held as exact.

    ``range_m`` is stated at 100 m. ``position_m`` is horizontal and vertical. ``roughness_m`` is that of the surface
    from point to point; ``form_m`` what a patch of 5 m by 10 degrees is off the circle, the same for all stations.
    ``levels`` says whether a fit takes the levels as they are, or adjusts them along with the axis.
    """

    range_m: float = 0.005
    angle_rad: float = 0.0
    level_rad: float = 0.0
    position_m: tuple[float, float] = (0.0, 0.0)
    heading_rad: float = 0.0
    roughness_m: float = 0.0
    form_m: float = 0.0
    levels: Levels = "held"

    def __post_init__(self) -> None:
        values = (self.range_m, self.angle_rad, self.level_rad, *self.position_m, self.heading_rad)
        if not np.isfinite(values).all() or min(*values, self.roughness_m, self.form_m) < 0.0:
            raise ShapeError(f"errors need finite standard deviations from 0 on; got {self!r}")
        if self.range_m + self.angle_rad + self.roughness_m == 0.0:
            raise ShapeError("errors need noise of the points: range, angle and roughness are 0")


@dataclass(frozen=True, slots=True)
class View:
    """Expected points (b, CELLS_ROUND) of a station, and the standard deviation of one, across the surface, metres."""

    counts: NDArray[np.float64]
    sigma_m: NDArray[np.float64]

    @property
    def is_seen(self) -> NDArray[np.bool_]:
        """Cells (b, CELLS_ROUND) that the station sees."""
        return self.counts > 0.0


def look(cells: Cells, site: Site, scanning: Scanning, errors: Errors, hidden: Sequence[Hidden] = ()) -> View:
    """Predict what a station sees of a shaft.

    A cone hides its far side and nothing else of itself. The scanner turns by equal steps in azimuth and elevation, so
    its beams lie closer the higher it looks. Across the surface a point is uncertain by
    sigma_n^2 = sigma_range^2 cos^2 i + (sigma_angle d)^2 sin^2 i + roughness^2, with the incidence i and distance d.
    """
    sight_m = cells.points_m - np.asarray(site.position_m)
    distance_m = np.linalg.norm(sight_m, axis=2)
    normal = cells.gradient / np.linalg.norm(cells.gradient, axis=2, keepdims=True)
    facing = -np.einsum("bsi,bsi->bs", sight_m, normal) / distance_m
    seen = (facing > np.cos(scanning.incidence_limit_rad)) & (distance_m <= scanning.reach_m)
    for obstacle in hidden:
        if obstacle.station in {None, site.station}:
            seen &= ~_behind(cells, obstacle)
    level = np.hypot(sight_m[..., 0], sight_m[..., 1]) / distance_m
    solid_angle = cells.area_m2 * np.maximum(facing, 0.0) / distance_m**2
    # straight above a scanner every beam of a turn meets
    counts = np.where(seen, solid_angle / (scanning.spacing_rad**2 * np.maximum(level, 1e-3)), 0.0)
    range_m = errors.range_m * np.maximum(distance_m / REFERENCE_RANGE_M, 0.5)
    across = (errors.angle_rad * distance_m) ** 2 * (1.0 - np.minimum(facing, 1.0) ** 2)
    return View(counts, np.sqrt((range_m * facing) ** 2 + across + errors.roughness_m**2))


def spacing_for(
    cells: Cells, site: Site, scanning: Scanning, n_points: float, hidden: Sequence[Hidden] = ()
) -> float:
    """Step of a grid, radians, that lays so many points on the cells; infinite where the station sees none."""
    seen = look(cells, site, scanning, Errors(), hidden).counts.sum()
    return float(scanning.spacing_rad * np.sqrt(seen / n_points)) if seen > 0.0 else np.inf


def _behind(cells: Cells, obstacle: Hidden) -> NDArray[np.bool_]:
    below = np.full(len(cells.bands.z_m), True)
    if obstacle.below_m is not None:
        below = cells.bands.z_m < obstacle.below_m
    inside = np.full(len(cells.azimuth_rad), True)
    if obstacle.azimuth_deg is not None:
        first, last = obstacle.azimuth_deg
        inside = (np.degrees(cells.azimuth_rad) - first) % 360.0 <= (last - first) % 360.0
    return np.asarray(below[:, None] & inside)
