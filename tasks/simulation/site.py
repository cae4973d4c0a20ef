"""What stands around the structure: ground, buildings, trees, lamp posts and a tank, all from a seed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.simulation.mesh import House, Mesh, Surface, beams, house_mesh, leaves, merge, tube

GROUND_REACH_M: Final = 420.0
"""The ground ends that far east, north, south and west of the structure."""

_GROUND_STEP_M: Final = 3.0
_ROUGHNESS_M: Final = 0.012
"""Standard deviation of the ground's vertices about the smooth terrain: gravel and grass."""

_SIGHT_HALF_WIDTH_M: Final = 12.0
"""Crews choose places from where they see the structure: nothing stands so near a line of sight."""

_CANDIDATES: Final = 600


@dataclass(frozen=True, slots=True)
class Terrain:
    """A smooth ground: a slope and some waves, zero at the structure's foot; site frame, metres."""

    slope: NDArray[np.float64]
    """(2,) rise to east and to north, dimensionless."""
    waves_per_m: NDArray[np.float64]
    """(k, 2) wave vectors, radians per metre."""
    phases_rad: NDArray[np.float64]
    amplitudes_m: NDArray[np.float64]

    def height_at(self, east_north_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height (...) above the structure's foot at places (..., 2)."""
        swell = np.sin(east_north_m @ self.waves_per_m.T + self.phases_rad) - np.sin(self.phases_rad)
        return np.asarray(east_north_m @ self.slope + swell @ self.amplitudes_m)


@dataclass(frozen=True, slots=True)
class Site:
    """The ground as a formula, and everything around the structure as meshes."""

    terrain: Terrain
    meshes: tuple[tuple[Surface, Mesh], ...]


@dataclass(frozen=True, slots=True)
class Surroundings:
    """How many things stand around; as many as find room are placed, all of them ``keep_off_m`` farther out."""

    houses: int = 14
    trees: int = 45
    lamp_posts: int = 8
    tanks: int = 1
    leaves_per_tree: int = 320
    keep_off_m: float = 0.0


def draw_terrain(rng: np.random.Generator) -> Terrain:
    """Draw a gently rolling ground: up to 0.4 % of slope, waves of 30 to 150 m and centimetres to decimetres."""
    n = 5
    wavelength_m = rng.uniform(30.0, 150.0, n)
    direction_rad = rng.uniform(0.0, 2.0 * np.pi, n)
    waves = (2.0 * np.pi / wavelength_m)[:, None] * np.column_stack(
        [np.sin(direction_rad), np.cos(direction_rad)]
    )
    return Terrain(
        rng.uniform(-0.004, 0.004, 2), waves, rng.uniform(0.0, 2.0 * np.pi, n), 0.001 * wavelength_m
    )


def build_site(
    stations_m: NDArray[np.float64], rng: np.random.Generator, surroundings: Surroundings | None = None
) -> Site:
    """Draw a site around the origin in which every station sees the structure.

    Parameters
    ----------
    stations_m : (n, 2) array
        Rough places of the stations, site frame.
    rng : Generator
        Source of everything that is random.
    surroundings : Surroundings, optional
        How many of each thing.
    """
    wanted = surroundings or Surroundings()
    terrain = draw_terrain(rng)
    room, off_m = _Room(stations_m, rng), wanted.keep_off_m
    # the large things first: they need the room
    houses = [
        _draw_house(place_m, terrain, rng)
        for place_m in room.claim(wanted.houses, 25.0 + off_m, 330.0, clear_m=13.0)
    ]
    tanks = [
        _draw_tank(place_m, terrain, rng)
        for place_m in room.claim(wanted.tanks, 25.0 + off_m, 90.0 + off_m, clear_m=7.0)
    ]
    trees = [
        _draw_tree(place_m, terrain, wanted.leaves_per_tree, rng)
        for place_m in room.claim(wanted.trees, 30.0 + off_m, 340.0, clear_m=4.0)
    ]
    posts_m = room.claim(wanted.lamp_posts, 15.0 + off_m, 120.0 + off_m, clear_m=1.0)
    return Site(
        terrain,
        (
            (Surface.GROUND, _ground_mesh(terrain, rng)),
            (Surface.BUILDING, merge([house_mesh(house) for house in houses])),
            (Surface.VEGETATION, merge(trees)),
            (Surface.FURNITURE, merge([*tanks, _lamp_posts(posts_m, terrain)])),
        ),
    )


class _Room:
    """The free places of a site; what is claimed is no longer free."""

    def __init__(self, stations_m: NDArray[np.float64], rng: np.random.Generator) -> None:
        self._stations_m = stations_m
        self._rng = rng
        self._taken: list[tuple[NDArray[np.float64], float]] = []

    def claim(self, n: int, nearest_m: float, farthest_m: float, clear_m: float) -> list[NDArray[np.float64]]:
        """Up to ``n`` places (2,), between two distances from the structure, each with ``clear_m`` of its own."""
        azimuth_rad = self._rng.uniform(0.0, 2.0 * np.pi, _CANDIDATES)
        # denser towards the structure, as a works is
        distance_m = nearest_m + (farthest_m - nearest_m) * self._rng.uniform(size=_CANDIDATES) ** 1.3
        places_m = np.column_stack([distance_m * np.sin(azimuth_rad), distance_m * np.cos(azimuth_rad)])
        found: list[NDArray[np.float64]] = []
        for place_m in places_m[_sees_past(places_m, self._stations_m, clear_m)]:
            if len(found) == n:
                break
            if all(np.hypot(*(place_m - other_m)) > clear_m + reach_m for other_m, reach_m in self._taken):
                found.append(place_m)
                self._taken.append((place_m, clear_m))
        return found


def _sees_past(
    places_m: NDArray[np.float64], stations_m: NDArray[np.float64], clear_m: float
) -> NDArray[np.bool_]:
    """Which places (n, 2) are clear of the lines from stations (m, 2) to the origin."""
    if len(stations_m) == 0:
        return np.ones(len(places_m), bool)
    length_sq = np.sum(stations_m**2, axis=1)
    share = np.clip(places_m @ stations_m.T / length_sq, 0.0, 1.0)
    off_m = np.linalg.norm(places_m[:, None] - share[..., None] * stations_m, axis=2)
    return np.asarray(off_m.min(axis=1) > clear_m + _SIGHT_HALF_WIDTH_M)


def _draw_house(place_m: NDArray[np.float64], terrain: Terrain, rng: np.random.Generator) -> House:
    eaves_m = rng.uniform(4.0, 11.0)
    width_m = rng.uniform(8.0, 13.0)
    # the walls start below the lowest ground around, so that none floats
    floor_m = float(terrain.height_at(place_m)) - 0.6
    return House(
        float(place_m[0]),
        float(place_m[1]),
        floor_m,
        rng.uniform(14.0, 22.0),
        width_m,
        eaves_m + 0.6,
        eaves_m + 0.6 + 0.25 * width_m,
        rng.uniform(0.0, np.pi),
    )


def _draw_tank(place_m: NDArray[np.float64], terrain: Terrain, rng: np.random.Generator) -> Mesh:
    radius_m, top_m = rng.uniform(3.0, 5.0), rng.uniform(8.0, 14.0)
    azimuth_rad = np.arange(96) * 2.0 * np.pi / 96
    ring = np.column_stack([np.sin(azimuth_rad), np.cos(azimuth_rad), np.zeros(96)])
    foot = np.append(place_m, terrain.height_at(place_m) - 0.5)
    rings = [
        foot + radius * ring + _up(up_m)
        for radius, up_m in ((radius_m, 0.0), (radius_m, top_m), (0.01, top_m + 1.0))
    ]
    return tube(np.stack(rings))


def _draw_tree(
    place_m: NDArray[np.float64], terrain: Terrain, n_leaves: int, rng: np.random.Generator
) -> Mesh:
    height_m = rng.uniform(4.0, 11.0)
    foot = np.append(place_m, terrain.height_at(place_m) - 0.2)
    crown_m = np.array([0.28, 0.28, 0.33]) * height_m * rng.uniform(0.8, 1.2, 3)
    centre_m = foot + _up(height_m - float(crown_m[2]))
    trunk = beams(foot[None], centre_m[None], 0.05 * height_m)
    return merge([trunk, leaves(centre_m, crown_m, n_leaves, 0.25, rng)])


def _lamp_posts(places_m: Sequence[NDArray[np.float64]], terrain: Terrain) -> Mesh:
    if not places_m:
        return merge([])
    feet = np.column_stack([np.vstack(places_m), terrain.height_at(np.vstack(places_m)) - 0.2])
    tops = feet + _up(8.0)
    return merge([beams(feet, tops, 0.16), beams(tops, tops + np.array([1.5, 0.0, 0.1]), 0.2)])


def _up(height_m: float) -> NDArray[np.float64]:
    return np.array([0.0, 0.0, height_m])


def _ground_mesh(terrain: Terrain, rng: np.random.Generator) -> Mesh:
    ticks_m = np.linspace(-GROUND_REACH_M, GROUND_REACH_M, int(2.0 * GROUND_REACH_M / _GROUND_STEP_M) + 1)
    east_m, north_m = (grid.ravel() for grid in np.meshgrid(ticks_m, ticks_m, indexing="ij"))
    up_m = terrain.height_at(np.column_stack([east_m, north_m])) + rng.normal(0.0, _ROUGHNESS_M, len(east_m))
    n = len(ticks_m)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.vstack(
        [
            np.column_stack([corner, corner + n, corner + n + 1]),
            np.column_stack([corner, corner + n + 1, corner + 1]),
        ]
    )
    return Mesh(np.column_stack([east_m, north_m, up_m]), triangles)
