"""The scanner: what it looks at, how finely, and how wrongly it measures."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

_GOLDEN: Final = 0.5 * (np.sqrt(5.0) - 1.0)
_REFERENCE_RANGE_M: Final = 100.0


@dataclass(frozen=True, slots=True)
class Scanner:
    """Standard deviations of one scanner and crew; all zero is a perfect one.

    The range noise is proportional to the range, as where the returned light sets it, and never below half of
    ``range_sigma_m``, which is stated at 100 m. It does not depend on the angle of incidence.
    ``position_sigma_m`` is of east and of north, ``height_sigma_m`` of up (GNSS).
    ``mixed_probability`` is that of a beam next to another surface to return a range between the two;
    ``stray_share`` is the share of shots that return a range without a surface.
    """

    range_sigma_m: float = 0.005
    angle_sigma_deg: float = 0.001
    level_sigma_deg: float = 0.0008
    position_sigma_m: float = 0.015
    height_sigma_m: float = 0.0225
    heading_sigma_deg: float = 0.15
    mixed_probability: float = 0.3
    stray_share: float = 0.0005
    reach_m: float = 500.0

    def range_sigma_at(self, range_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Standard deviation (n,) of ranges (n,), metres."""
        return np.asarray(self.range_sigma_m * np.maximum(range_m / _REFERENCE_RANGE_M, 0.5))


PERFECT_SCANNER: Final = Scanner(
    range_sigma_m=0.0,
    angle_sigma_deg=0.0,
    level_sigma_deg=0.0,
    position_sigma_m=0.0,
    height_sigma_m=0.0,
    heading_sigma_deg=0.0,
    mixed_probability=0.0,
    stray_share=0.0,
)


@dataclass(frozen=True, slots=True)
class Window:
    """A part of the sphere that is scanned on its own grid, and its share of the station's points.

    Azimuths run clockwise from the scanner's +y axis, elevations up from its x-y plane, radians.
    """

    azimuth_rad: float
    half_width_rad: float
    lowest_rad: float
    highest_rad: float
    share: float


@dataclass(frozen=True, slots=True)
class ShotGrid:
    """Directions of shots, columns first: both arrays are (n_columns, n_shots), radians, scanner frame."""

    azimuth_rad: NDArray[np.float64]
    elevation_rad: NDArray[np.float64]

    def directions(self) -> NDArray[np.float64]:
        """Unit vectors (n_columns * n_shots, 3), scanner frame."""
        return unit_vectors(self.azimuth_rad.ravel(), self.elevation_rad.ravel())


def unit_vectors(azimuth_rad: NDArray[np.float64], elevation_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (n, 3) of the scanner frame from azimuths and elevations (n,)."""
    level = np.cos(elevation_rad)
    return np.column_stack([level * np.sin(azimuth_rad), level * np.cos(azimuth_rad), np.sin(elevation_rad)])


def shot_grid(window: Window, n_shots: float, phase: float) -> ShotGrid:
    """About ``n_shots`` directions, as far apart in azimuth as in elevation.

    The mirror is not locked to the azimuth drive: the first shot of each column comes at another phase (0 to 1
    of the step, golden section from ``phase``). So a thin level slice of the structure meets some columns of
    every scan, instead of a whole row of one and none of another.
    """
    width_rad, tall_rad = 2.0 * window.half_width_rad, window.highest_rad - window.lowest_rad
    columns = max(1, round(float(np.sqrt(n_shots * width_rad / tall_rad))))
    shots = max(1, round(n_shots / columns))
    start = (phase + _GOLDEN * np.arange(columns)) % 1.0
    azimuth_rad = (
        window.azimuth_rad - window.half_width_rad + (np.arange(columns) + 0.5) * width_rad / columns
    )
    elevation_rad = window.lowest_rad + (np.arange(shots) + start[:, None]) * tall_rad / shots
    return ShotGrid(np.broadcast_to(azimuth_rad[:, None], elevation_rad.shape), elevation_rad)
