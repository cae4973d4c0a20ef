"""The shaft as the later stages need it: rough axis, radius, taper and noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError


@dataclass(frozen=True, slots=True)
class ShaftModel:
    """Robust model of a shaft in the site frame, metres.

    ``base_east_m``, ``base_north_m`` and the lean vector are the straight line that fits the axis best, uniformly
    over the height; the base is its point at z = 0. ``bend_east_m`` and ``bend_north_m`` are what the axis is off
    that line at the knots ``radius_z_m``, ``radius_m`` the mean radius there; all are linear between the knots
    and go on with the last value beyond them. ``noise_sigma_m`` is the robust deviation of the points from the surface.
    """

    base_east_m: float
    base_north_m: float
    lean_east: float
    lean_north: float
    radius_z_m: tuple[float, ...]
    radius_m: tuple[float, ...]
    bend_east_m: tuple[float, ...]
    bend_north_m: tuple[float, ...]
    noise_sigma_m: float

    def __post_init__(self) -> None:
        n = len(self.radius_z_m)
        if n < 2 or {len(self.radius_m), len(self.bend_east_m), len(self.bend_north_m)} != {n}:
            raise ShapeError("ShaftModel needs at least 2 knots and as many radii and bends as knots")

    def straight_axis_at(self, z_m: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Position (..., 2) of the straight axis at heights (...), east and north in metres."""
        z = np.asarray(z_m, dtype=np.float64)
        return np.stack(
            [self.base_east_m + self.lean_east * z, self.base_north_m + self.lean_north * z], axis=-1
        )

    def axis_at(self, z_m: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Position (..., 2) of the axis, bending included, at heights (...); east and north in metres."""
        bend = [np.interp(z_m, self.radius_z_m, bend_m) for bend_m in (self.bend_east_m, self.bend_north_m)]
        return np.asarray(self.straight_axis_at(z_m) + np.stack(bend, axis=-1))

    def radius_at(self, z_m: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Mean radius (...) at heights (...), metres."""
        return np.asarray(np.interp(z_m, self.radius_z_m, self.radius_m))

    def taper_at(self, z_m: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Change of radius per metre of height (...), negative for a shaft that narrows upward."""
        slopes = np.diff(self.radius_m) / np.diff(self.radius_z_m)
        knot = np.searchsorted(self.radius_z_m, np.asarray(z_m, dtype=np.float64), side="right") - 1
        return np.asarray(slopes[np.clip(knot, 0, len(slopes) - 1)])
