"""The two horizontal directions in which an engineer looks at a leaning axis: along the lean and across it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.records import TiltRow


@dataclass(frozen=True, slots=True)
class Direction:
    """Along is the azimuth clockwise from grid north, across is 90 degrees clockwise from it.

    ``is_lean`` is False where no lean is significant: then along is north and across is east.
    """

    azimuth_deg: float
    is_lean: bool

    def turn(self, east_north: NDArray[np.float64]) -> NDArray[np.float64]:
        """Turn vectors (..., 2) of east and north into (..., 2) of along and across."""
        return east_north @ self._rotation().T

    def turn_covariance(self, covariance: NDArray[np.float64]) -> NDArray[np.float64]:
        """Turn covariances (..., 2, 2) of east and north into those of along and across."""
        rotation = self._rotation()
        return rotation @ covariance @ rotation.T

    @property
    def words(self) -> tuple[str, str]:
        """The two directions by name."""
        if not self.is_lean:
            return "north", "east"
        across_deg = (self.azimuth_deg + 90.0) % 360.0
        return f"along the lean ({self.azimuth_deg:.0f}°)", f"across the lean ({across_deg:.0f}°)"

    def _rotation(self) -> NDArray[np.float64]:
        sine, cosine = math.sin(math.radians(self.azimuth_deg)), math.cos(math.radians(self.azimuth_deg))
        return np.array([[sine, cosine], [cosine, -sine]])


def direction_of(tilt: TiltRow | None) -> Direction:
    """Return the direction of lean, or north where there is no lean that is significant."""
    if tilt is None or tilt.azimuth_deg is None:
        return Direction(0.0, is_lean=False)
    return Direction(tilt.azimuth_deg, is_lean=True)
