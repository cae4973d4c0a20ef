"""A parallel view from outside onto points in space: no vanishing point, so that lengths compare."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class ObliqueView:
    """A view along a direction: ``from_azimuth_deg`` where the viewer stands, so many degrees above the horizon."""

    from_azimuth_deg: float
    above_deg: float

    def seen(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Right, up and towards the viewer (n, 3) of points (n, 3) east, north, up."""
        azimuth, above = np.radians([self.from_azimuth_deg, self.above_deg])
        towards = np.array([np.sin(azimuth), np.cos(azimuth), 0.0])
        right = np.array([-np.cos(azimuth), np.sin(azimuth), 0.0])
        up = np.array([0.0, 0.0, np.cos(above)]) - np.sin(above) * towards
        depth = np.cos(above) * towards + np.array([0.0, 0.0, np.sin(above)])
        return np.asarray(points_m @ np.column_stack([right, up, depth]))
