"""Synthetic clouds of a square tower with known truth; not a test."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.faces import normals_of, tangents_of
from tasks.preprocessing import StructurePrior

SQUARE: Final = StructurePrior("square-tower", (1.0, 41.0), (0.0, 0.0), (3.0, 2.2))

SQUARE_LEAN: Final = np.array([0.008, -0.005])
"""True lean of every scene's tower."""

SQUARE_BASE: Final = np.array([0.3, -0.2])
"""True place of its axis at z = 0, metres."""

SQUARE_AZIMUTH_RAD: Final = 0.4
"""Azimuth of the normal of its first face at z = 0."""


@dataclass(frozen=True, slots=True)
class Square:
    """What a tower looks like: half sides at z = 1 and 41 m of the two directions, noise, twist, and bending at 41 m."""

    first_m: tuple[float, float] = (3.0, 2.2)
    second_m: tuple[float, float] = (3.0, 2.2)
    noise_m: float = 0.006
    twist_rad_per_m: float = 0.0
    bend_m: float = 0.0

    def half_m(self, face: NDArray[np.intp], z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distances (n,) of faces (n,) from the axis at heights (n,)."""
        first, second = (np.interp(z_m, (1.0, 41.0), ends) for ends in (self.first_m, self.second_m))
        return np.where(face % 2 == 0, first, second)

    def axis_m(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """East and north (n, 2) of the axis."""
        bend = self.bend_m * ((z_m - 1.0) / 40.0) ** 2
        return np.asarray(SQUARE_BASE + z_m[:, None] * SQUARE_LEAN + bend[:, None] * [1.0, 0.0])


def square_cloud(
    rng: np.random.Generator,
    n: int = 20_000,
    faces: tuple[int, ...] = (0, 1, 2, 3),
    square: Square | None = None,
    z_m: tuple[float, float] = (0.0, 42.0),
) -> NDArray[np.float64]:
    """Points (n, 3) on some faces of the tower, from below its shaft to above."""
    tower = Square() if square is None else square
    z = rng.uniform(*z_m, n)
    face = rng.choice(np.array(faces), n)
    azimuth = SQUARE_AZIMUTH_RAD + face * np.pi / 2 + tower.twist_rad_per_m * z
    out = tower.half_m(face, z) + rng.normal(0.0, tower.noise_m, n)
    along = tower.half_m(face + 1, z) * rng.uniform(-1.0, 1.0, n)
    xy = tower.axis_m(z) + out[:, None] * normals_of(azimuth) + along[:, None] * tangents_of(azimuth)
    return np.column_stack([xy, z])


def square_ladder(rng: np.random.Generator, n: int = 2_000) -> NDArray[np.float64]:
    """Points (n, 3) of a ladder 0.5 m wide, 0.2 m off the first face."""
    z = rng.uniform(0.0, 42.0, n)
    out = Square().half_m(np.zeros(n, dtype=np.intp), z) + 0.2 + rng.normal(0.0, 0.01, n)
    along = rng.choice([-0.25, 0.25], n)
    azimuth = np.array(SQUARE_AZIMUTH_RAD)
    xy = Square().axis_m(z) + np.outer(out, normals_of(azimuth)) + np.outer(along, tangents_of(azimuth))
    return np.column_stack([xy, z])


def long_wall(rng: np.random.Generator, n: int = 15_000) -> NDArray[np.float64]:
    """Points (n, 3) of a wall beside the tower that runs in another direction and is denser than its faces."""
    return np.column_stack(
        [rng.uniform(-8.0, 8.0, n), -7.0 + rng.normal(0.0, 0.01, n), rng.uniform(0.0, 20.0, n)]
    )


def gallery(rng: np.random.Generator, n: int = 4_000) -> NDArray[np.float64]:
    """Points (n, 3) of a platform around the tower at 30 m."""
    xy = rng.uniform(-3.8, 3.8, (4 * n, 2))
    outside = np.abs(xy).max(axis=1) > 2.5
    xy = (xy[outside] @ np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]]))[:n]
    z = 30.0 + rng.normal(0.0, 0.02, len(xy))
    return np.column_stack([xy + Square().axis_m(z), z])


def square_epoch(rng: np.random.Generator, square: Square | None = None) -> NDArray[np.float64]:
    """Points (n, 3) of four stations that see two faces each, one of them far away, and of a ladder."""
    seen = [
        square_cloud(rng, n, (i, (i + 1) % 4), square) for i, n in enumerate((4_000, 6_000, 5_000, 1_500))
    ]
    return np.vstack([*seen, square_ladder(rng)])
