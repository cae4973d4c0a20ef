"""Walls that a taper does not tell: steps of the radius, plane faces, roughness, a roof."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.simulation.mesh import Mesh, tube
from tasks.simulation.shape import ShaftShape

CHORD_TOLERANCE_M: Final = 2e-5
"""How far the facets of a round wall may lie inside it; it is even all around."""

BELOW_GROUND_M: Final = 1.5

_ALONG_FACE: Final = 24
"""Vertices of a ring on each plane face."""

_ROOF_TIP_M: Final = 0.01


@dataclass(frozen=True, slots=True)
class Bumps:
    """Roughness: standard deviation of what the wall is off, and how tall and wide one bump is; metres.

    A wall keeps its bumps from epoch to epoch; ``seed`` says which wall it is.
    """

    sigma_m: float
    tall_m: float
    wide_m: float
    seed: int = 1

    def __post_init__(self) -> None:
        if min(self.sigma_m, self.tall_m, self.wide_m) <= 0.0:
            raise ShapeError(f"bumps need sizes above 0; got {self}")


@dataclass(frozen=True, slots=True)
class Wall:
    """What the wall has beyond the taper of its shape.

    ``profile_m`` holds heights and what the radius has there more than the shape, linear between, constant beyond; a
    height that stands twice is a step. ``faces`` plane faces (0: round) make the radius half of a side, the first face
    looks towards ``face_azimuth_deg``. ``roof_m`` is the height of a cone on top. ``ring_step_m`` is how far apart the
    rings of the mesh are at most.
    """

    profile_m: tuple[tuple[float, float], ...] = ()
    bumps: Bumps | None = None
    faces: int = 0
    face_azimuth_deg: float = 0.0
    roof_m: float = 0.0
    ring_step_m: float = 2.0

    def __post_init__(self) -> None:
        heights = [height for height, _ in self.profile_m]
        if heights != sorted(heights) or self.faces not in (0, 4) or self.ring_step_m <= 0.0:
            raise ShapeError(
                f"a wall needs a profile with rising heights, 0 or 4 faces and a step of rings above 0; got {self}"
            )

    def added_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the radius (...) has more than the shape at heights (...), metres; at a step the upper value."""
        if not self.profile_m:
            return np.zeros_like(z_m)
        heights, added = np.array(self.profile_m).T
        return np.asarray(np.interp(z_m, heights, added))


def wall_mesh(shape: ShaftShape, wall: Wall) -> Mesh:
    """Skin of the structure, site frame; its sections are horizontal."""
    z_m, added_m = _rings(shape.height_m, wall)
    mean_m = shape.radius_at(z_m) + added_m
    azimuth_rad, reach = _outline(shape, wall, float(mean_m.max()))
    reach_m = mean_m[:, None] * reach + _bumps_m(wall, z_m, len(azimuth_rad), float(mean_m.mean()))
    rings = np.concatenate([shape.axis_at(z_m), z_m[:, None]], axis=1)[:, None, :]
    out = np.column_stack([np.sin(azimuth_rad), np.cos(azimuth_rad), np.zeros(len(azimuth_rad))])
    skin_m = rings + reach_m[..., None] * out
    if wall.roof_m > 0.0:
        tip_m = rings[-1] + _ROOF_TIP_M * out + np.array([0.0, 0.0, wall.roof_m])
        skin_m = np.concatenate([skin_m, tip_m[None]])
    return tube(skin_m)


def _rings(height_m: float, wall: Wall) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Heights (k,) of the rings, and what each has more than the shape (k,): two at one height where there is a step."""
    n = int(np.ceil((height_m + BELOW_GROUND_M) / wall.ring_step_m)) + 1
    even_m = np.linspace(-BELOW_GROUND_M, height_m, n)
    if not wall.profile_m:
        return even_m, np.zeros(n)
    heights, added = np.array(wall.profile_m).T
    free_m = even_m[~np.isin(even_m, heights)]
    z_m = np.concatenate([free_m, heights])
    more_m = np.concatenate([np.interp(free_m, heights, added), added])
    order = np.argsort(z_m, kind="stable")
    return z_m[order], more_m[order]


def _outline(
    shape: ShaftShape, wall: Wall, widest_m: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Azimuths (n,) of the vertices of a ring, and their distances (n,) in units of the radius or half side."""
    if wall.faces:
        along = np.linspace(-1.0, 1.0, _ALONG_FACE, endpoint=False)
        turn = np.radians(wall.face_azimuth_deg) + np.arange(wall.faces) * np.pi / 2.0
        azimuth_rad = (turn[:, None] + np.arctan(along)).ravel()
        return azimuth_rad, np.tile(np.hypot(1.0, along), wall.faces)
    n = int(np.ceil(np.pi / np.arccos(1.0 - CHORD_TOLERANCE_M / widest_m)))
    azimuth_rad = np.arange(n) * 2.0 * np.pi / n
    return azimuth_rad, shape.roundness_at(azimuth_rad)


def _bumps_m(wall: Wall, z_m: NDArray[np.float64], n_around: int, radius_m: float) -> NDArray[np.float64]:
    """What the wall is off (k, n) at the vertices of its rings: a coarse random grid, linear between."""
    bumps = wall.bumps
    if bumps is None:
        return np.zeros((len(z_m), n_around))
    around = max(3, round(2.0 * np.pi * radius_m / bumps.wide_m))
    up = (z_m - z_m[0]) / bumps.tall_m
    grid = np.random.default_rng(bumps.seed).normal(0.0, bumps.sigma_m, (int(up[-1]) + 2, around))
    place = np.arange(n_around) * around / n_around
    left, low = place.astype(int), up.astype(int)
    share, rise = place - left, (up - low)[:, None]
    lower, upper = (
        grid[rows][:, left] * (1.0 - share) + grid[rows][:, (left + 1) % around] * share
        for rows in (low, low + 1)
    )
    return np.asarray(lower * (1.0 - rise) + upper * rise)
