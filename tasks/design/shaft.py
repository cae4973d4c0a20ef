"""The shaft as a plan knows it: a leaning cone, cut into cells of height band and azimuth."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

CELL_DEG: Final = 2.5
"""Width of a cell: the edge of what a station sees moves by half of it at most."""

CELLS_ROUND: Final = 144

BAND_M: Final = 2.5
FEWEST_BANDS: Final = 40
MOST_BANDS: Final = 160
"""Between these the heights inside a band may be taken as one: the lean's sigma changes by less than 0.1 %."""


@dataclass(frozen=True, slots=True)
class Shaft:
    """A round shaft with a straight axis and a straight taper.

    ``z_m`` are its lower and upper end and ``radius_m`` the radii there; ``base_xy_m`` is the axis at the lower end,
    east and north in the site frame, metres. ``lean`` is the expected lean vector.
    """

    z_m: tuple[float, float]
    radius_m: tuple[float, float]
    base_xy_m: tuple[float, float] = (0.0, 0.0)
    lean: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        values = (*self.z_m, *self.radius_m, *self.base_xy_m, *self.lean)
        if not (np.isfinite(values).all() and self.z_m[0] < self.z_m[1] and min(self.radius_m) > 0.0):
            raise ShapeError(f"a shaft needs heights that rise and radii above 0 m; got {self!r}")

    @property
    def length_m(self) -> float:
        """From the lower to the upper end."""
        return self.z_m[1] - self.z_m[0]

    @property
    def radius_slope(self) -> float:
        """Change of the radius by height, m/m."""
        return (self.radius_m[1] - self.radius_m[0]) / self.length_m


@dataclass(frozen=True, slots=True)
class Bands:
    """Heights at which the shaft is measured: middles (b,) and how much height each stands for (b,), metres."""

    z_m: NDArray[np.float64]
    thickness_m: NDArray[np.float64]

    def __post_init__(self) -> None:
        if self.z_m.ndim != 1 or not len(self.z_m) or self.z_m.shape != self.thickness_m.shape:
            raise ShapeError(
                f"bands need heights (b,) and thicknesses (b,); got {self.z_m.shape} and {self.thickness_m.shape}"
            )


@dataclass(frozen=True, slots=True)
class Cells:
    """The surface in cells of band and azimuth, (b, CELLS_ROUND, ...), site frame, metres.

    ``gradient`` is the derivative of a point's distance from the surface, counted horizontally, by the point: the
    outward normal times a factor near 1. ``azimuth_rad`` (CELLS_ROUND,) is that of the middles about the axis.
    """

    shaft: Shaft
    bands: Bands
    azimuth_rad: NDArray[np.float64]
    points_m: NDArray[np.float64]
    gradient: NDArray[np.float64]
    area_m2: NDArray[np.float64]


def whole_surface(shaft: Shaft) -> Bands:
    """Bands that lie on each other from the lower to the upper end."""
    n = int(np.clip(np.ceil(shaft.length_m / BAND_M), FEWEST_BANDS, MOST_BANDS))
    step_m = shaft.length_m / n
    return Bands(shaft.z_m[0] + step_m * np.arange(0.5, n), np.full(n, step_m, dtype=np.float64))


def slices(z_m: NDArray[np.float64], thickness_m: float) -> Bands:
    """Bands of slices at heights (m,); neighbours are joined where there are more than MOST_BANDS."""
    groups = np.array_split(np.sort(z_m), min(len(z_m), MOST_BANDS))
    return Bands(
        np.array([float(group.mean()) for group in groups]),
        np.array([thickness_m * len(group) for group in groups]),
    )


def cut_cells(shaft: Shaft, bands: Bands) -> Cells:
    """Cut the surface of a shaft into cells."""
    azimuth = 2.0 * np.pi * (np.arange(CELLS_ROUND) + 0.5) / CELLS_ROUND
    outward = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    above_m = bands.z_m - shaft.z_m[0]
    radius_m = shaft.radius_m[0] + shaft.radius_slope * above_m
    axis_m = np.asarray(shaft.base_xy_m) + np.outer(above_m, shaft.lean)
    shape = (len(bands.z_m), CELLS_ROUND)
    points_m = np.empty((*shape, 3))
    points_m[..., :2] = axis_m[:, None] + radius_m[:, None, None] * outward
    points_m[..., 2] = bands.z_m[:, None]
    gradient = np.empty((*shape, 3))
    gradient[..., :2] = outward
    gradient[..., 2] = -outward @ np.asarray(shaft.lean) - shaft.radius_slope
    steepness = np.linalg.norm(gradient, axis=2)
    area_m2 = (radius_m * bands.thickness_m)[:, None] * steepness * (2.0 * np.pi / CELLS_ROUND)
    return Cells(shaft, bands, azimuth, points_m, gradient, area_m2)
