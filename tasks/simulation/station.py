"""Where scanners stand, what they truly do there, and what the crew believes about it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from storage.errors import ShapeError
from tasks.conventions import rotation_site_scanner
from tasks.simulation.layout import Layout
from tasks.simulation.scanner import Scanner
from tasks.simulation.site import Terrain

_UNEVENNESS: Final = 0.3
"""Azimuths stray from even ones by up to that share of their spacing."""

_TRIPOD_LOWEST_M: Final = 1.5
_TRIPOD_HIGHEST_M: Final = 2.0


@dataclass(frozen=True, slots=True)
class Setup:
    """One set-up of a scanner: the truth, and the stated pose that the crew writes down.

    ``position_m`` and ``stated_position_m`` (3,) are of the scanner's centre in the site frame. The level errors
    are true rotations about site east and north that the crew does not know: they are in the points. ``margin_m`` is how
    far beyond the structure the crew lets the fine window reach.
    """

    station: str
    position_m: NDArray[np.float64]
    heading_rad: float
    level_east_rad: float
    level_north_rad: float
    stated_position_m: NDArray[np.float64]
    stated_heading_rad: float
    margin_m: float = Layout().margin_m

    @property
    def rotation_site_scanner(self) -> NDArray[np.float64]:
        """True rotation (3, 3): points_site = R @ points_scanner + position."""
        level = Rotation.from_rotvec([self.level_east_rad, self.level_north_rad, 0.0]).as_matrix()
        return np.asarray(level @ rotation_site_scanner(self.heading_rad))

    def to_site(self, points_scanner_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) of the true scanner frame in the site frame, by the true pose and level."""
        return np.asarray(points_scanner_m @ self.rotation_site_scanner.T + self.position_m)


def draw_station_places(
    n: int, rng: np.random.Generator, layout: Layout | None = None
) -> NDArray[np.float64]:
    """Draw ``n`` places (n, 2) around the origin, as far away as the layout says, at uneven azimuths."""
    if n < 1:
        raise ShapeError(f"a campaign needs at least 1 station; got {n}")
    spacing_rad = 2.0 * np.pi / n
    azimuth_rad = (np.arange(n) + rng.uniform(-_UNEVENNESS, _UNEVENNESS, n) + rng.uniform()) * spacing_rad
    distance_m = rng.uniform(*(layout or Layout()).distance_m, n)
    return np.column_stack([distance_m * np.sin(azimuth_rad), distance_m * np.cos(azimuth_rad)])


def set_up_station(
    station: str,
    place_m: NDArray[np.float64],
    terrain: Terrain,
    scanner: Scanner,
    rng: np.random.Generator,
    margin_m: float = Layout().margin_m,
) -> Setup:
    """Set up a scanner at a place (2,) with a random heading, level error, and stated pose.

    The true position is rounded to what single precision holds, so that the ray caster starts exactly there.
    """
    up_m = float(terrain.height_at(place_m)) + rng.uniform(_TRIPOD_LOWEST_M, _TRIPOD_HIGHEST_M)
    position_m = np.append(place_m, up_m).astype(np.float32).astype(np.float64)
    heading_rad = rng.uniform(0.0, 2.0 * np.pi)
    level_rad = np.radians(scanner.level_sigma_deg) * rng.normal(size=2)
    sigma_m = np.array([scanner.position_sigma_m, scanner.position_sigma_m, scanner.height_sigma_m])
    stated_position_m = position_m + sigma_m * rng.normal(size=3)
    stated_heading_rad = heading_rad + np.radians(scanner.heading_sigma_deg) * rng.normal()
    return Setup(
        station,
        position_m,
        heading_rad,
        float(level_rad[0]),
        float(level_rad[1]),
        stated_position_m,
        float(stated_heading_rad % (2.0 * np.pi)),
        margin_m,
    )
