"""A circle, and how points lie on it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

SECTOR_DEG: Final = 5.0
"""Width of the sectors in which the covered part of a circumference is counted, degrees."""


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle in a horizontal plane, metres."""

    east_m: float
    north_m: float
    radius_m: float

    @property
    def finite(self) -> bool:
        """Whether all three numbers are finite and the radius is above 0."""
        return bool(np.isfinite([self.east_m, self.north_m, self.radius_m]).all() and self.radius_m > 0.0)


def center_distances(xy_m: NDArray[np.float64], circle: Circle) -> NDArray[np.float64]:
    """Distances (n,) of points (n, 2) from the centre, metres."""
    east, north = xy_m[:, 0] - circle.east_m, xy_m[:, 1] - circle.north_m
    # lengths of metres cannot overflow, and np.hypot guards against that at five times the cost
    return np.asarray(np.sqrt(east * east + north * north))


def arc_coverage_deg(xy_m: NDArray[np.float64], circle: Circle) -> float:
    """Sectors of 5 degrees about the centre that hold at least one of the points (n, 2), degrees."""
    angle = np.degrees(np.arctan2(xy_m[:, 1] - circle.north_m, xy_m[:, 0] - circle.east_m)) % 360.0
    # an angle of -1e-15 becomes 360.0, which is sector 0
    sectors = np.floor(angle / SECTOR_DEG).astype(np.intp) % int(360.0 / SECTOR_DEG)
    return SECTOR_DEG * float(np.count_nonzero(np.bincount(sectors)))
