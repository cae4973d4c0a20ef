"""The shaft as the later stages need it: rough axis, radius, taper and noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.faces import split_by_face


@dataclass(frozen=True, slots=True)
class ShaftFace:
    """A plane face of a shaft.

    ``azimuth_rad`` is that of its outward normal at z = 0, clockwise from grid north; ``distance_m`` its horizontal
    distance from the axis at the knots of the model. ``sigma_m`` is the standard deviation of half the side between it
    and the opposite face at the knots; None where one of the two was not seen: the distance is then a guess.
    """

    azimuth_rad: float
    distance_m: tuple[float, ...]
    sigma_m: tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class ShaftModel:
    """Robust model of a shaft in the site frame, metres.

    ``base_east_m``, ``base_north_m`` and the lean vector are the straight line that fits the axis best, uniformly
    over the height; the base is its point at z = 0. ``bend_east_m`` and ``bend_north_m`` are what the axis is off
    that line at the knots ``radius_z_m``, ``radius_m`` the mean radius there; all are linear between the knots
    and go on with the last value beyond them. ``noise_sigma_m`` is the robust deviation of the points from the surface.
    A shaft with plane faces has them in ``faces``, clockwise, an even number; its ``radius_m`` is half the mean side, and
    all faces turn clockwise by ``twist_rad_per_m``. A round shaft has no faces.
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
    faces: tuple[ShaftFace, ...] = ()
    twist_rad_per_m: float = 0.0

    def __post_init__(self) -> None:
        n = len(self.radius_z_m)
        if n < 2 or {len(self.radius_m), len(self.bend_east_m), len(self.bend_north_m)} != {n}:
            raise ShapeError("ShaftModel needs at least 2 knots and as many radii and bends as knots")
        if len(self.faces) % 2 or any(len(face.distance_m) != n for face in self.faces):
            raise ShapeError("ShaftModel needs an even number of faces with as many distances as knots")

    @property
    def is_round(self) -> bool:
        """Whether the shaft has no plane faces."""
        return not self.faces

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

    def face_azimuths_rad(self, z_m: float) -> NDArray[np.float64]:
        """Azimuths (m,) of the outward normals of the faces at a height, clockwise from grid north."""
        return np.array([face.azimuth_rad for face in self.faces]) + self.twist_rad_per_m * z_m

    def face_distances_at(self, z_m: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Distances (..., m) of the faces from the axis at heights (...), metres."""
        return np.stack([np.interp(z_m, self.radius_z_m, face.distance_m) for face in self.faces], axis=-1)

    def off_surface_m(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Horizontal distance (n,) of points (n, 3) from the surface, positive outside, metres."""
        z_m = points_m[:, 2]
        ray_m = points_m[:, :2] - self.axis_at(z_m)
        if self.is_round:
            return np.asarray(np.hypot(ray_m[:, 0], ray_m[:, 1]) - self.radius_at(z_m))
        turn = self.twist_rad_per_m * z_m
        return split_by_face(ray_m, self.face_azimuths_rad(0.0), self.face_distances_at(z_m), turn).off
