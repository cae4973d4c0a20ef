"""What is known of a structure before its cloud is looked at, and how its shaft is to be found."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

BANDS_MIN: Final = 8
BANDS_MAX: Final = 40
"""Height bands of the search: enough to outvote bad ones, few enough to hold points."""


@dataclass(frozen=True, slots=True)
class StructurePrior:
    """Rough knowledge of a structure, in the site frame.

    ``shaft_z_m`` (lowest, highest) is the part to be isolated; ``base_xy_m`` the position at its foot, good to
    about a metre (0.2 m for thin kinds); ``radius_m`` the radii at the two ends of ``shaft_z_m``, good to 30 %
    (to half for stems).
    """

    kind: str
    shaft_z_m: tuple[float, float]
    base_xy_m: tuple[float, float]
    radius_m: tuple[float, float]

    def __post_init__(self) -> None:
        if not self.shaft_z_m[1] > self.shaft_z_m[0]:
            raise ShapeError(f"shaft_z_m needs the lower height first, got {self.shaft_z_m}")
        if not min(self.radius_m) > 0.0:
            raise ShapeError(f"radius_m needs positive radii, got {self.radius_m}")

    def radius_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Prior radius at heights (n,), linear between the two ends; metres."""
        return np.interp(z_m, self.shaft_z_m, self.radius_m)

    def band_edges_m(self) -> NDArray[np.float64]:
        """Edges (k + 1,) of height bands about one radius tall, metres."""
        height_m = self.shaft_z_m[1] - self.shaft_z_m[0]
        wanted = round(height_m / float(np.mean(self.radius_m)))
        return np.linspace(*self.shaft_z_m, int(np.clip(wanted, BANDS_MIN, BANDS_MAX)) + 1)


@dataclass(frozen=True, slots=True)
class ShaftOptions:
    """Settings of the isolation.

    A point stays if its distance from the surface is within ``gate_sigmas`` times the robust noise plus
    ``gate_radius_fraction`` of the radius, on both sides alike, so that the gate moves no centre.
    It is isolated with fewer than ``min_neighbours`` others near it on the surface, and a duplicate if an
    earlier point lies in the same cube of ``voxel_m``. Of many more than ``most_points`` on the surface one of every
    so many stays. ``seed`` makes the random search repeatable.
    """

    voxel_m: float = 0.005
    gate_sigmas: float = 4.0
    gate_radius_fraction: float = 0.005
    min_neighbours: int = 3
    most_points: int = 8_000_000
    seed: int = 20250314

    def __post_init__(self) -> None:
        if not (self.voxel_m > 0.0 and self.gate_sigmas > 0.0 and self.gate_radius_fraction >= 0.0):
            raise ShapeError(f"ShaftOptions needs positive voxel_m and gate_sigmas, got {self}")
