"""Triangle meshes and the few solids a site is made of; site frame, metres."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError


class Surface(IntEnum):
    """What a simulated point lies on, or how it came about."""

    SHAFT = 0
    PLATFORM = 1
    LADDER = 2
    GROUND = 3
    BUILDING = 4
    VEGETATION = 5
    FURNITURE = 6
    """Lamp posts and tanks."""
    MIXED = 7
    """A beam that two surfaces shared: a range in between."""
    STRAY = 8
    """Dust, birds, sparkle: a range without a surface."""


@dataclass(frozen=True, slots=True)
class Mesh:
    """Vertices (n, 3), metres, and triangles (m, 3) of their indices."""

    vertices_m: NDArray[np.float64]
    triangles: NDArray[np.int64]


_BOX_CORNERS: Final = np.array(
    [[i, j, k] for k in (0.0, 1.0) for i, j in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
)
_BOX_TRIANGLES: Final = np.array(
    [
        *([0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]),
        *([0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]),
    ]
)
# a house: the box's walls, then two roof planes and two gables over the ridge points 8 and 9
_HOUSE_TRIANGLES: Final = np.vstack(
    [
        _BOX_TRIANGLES[:8],
        [[5, 6, 9], [5, 9, 8], [7, 4, 8], [7, 8, 9], [4, 5, 8], [6, 7, 9]],
    ]
)


def merge(meshes: Sequence[Mesh]) -> Mesh:
    """Join meshes into one; none gives an empty mesh."""
    starts = np.cumsum([0, *(len(mesh.vertices_m) for mesh in meshes)])
    return Mesh(
        np.vstack([np.empty((0, 3)), *(mesh.vertices_m for mesh in meshes)]),
        np.vstack(
            [
                np.empty((0, 3), np.int64),
                *(mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)),
            ]
        ),
    )


def tube(rings_m: NDArray[np.float64]) -> Mesh:
    """Skin between consecutive closed rings (k, n, 3) with the same number of vertices."""
    if rings_m.ndim != 3 or rings_m.shape[0] < 2 or rings_m.shape[1] < 3 or rings_m.shape[2] != 3:
        raise ShapeError(f"tube needs rings (k, n, 3) with k >= 2 and n >= 3; got {rings_m.shape}")
    k, n = rings_m.shape[:2]
    here = (np.arange(k - 1)[:, None] * n + np.arange(n)).ravel()
    right = (np.arange(k - 1)[:, None] * n + (np.arange(n) + 1) % n).ravel()
    triangles = np.vstack(
        [np.column_stack([here, right, right + n]), np.column_stack([here, right + n, here + n])]
    )
    return Mesh(rings_m.reshape(-1, 3), triangles)


def beams(starts_m: NDArray[np.float64], ends_m: NDArray[np.float64], width_m: float) -> Mesh:
    """Bars of square section ``width_m`` from ``starts_m`` (n, 3) to ``ends_m`` (n, 3)."""
    along = ends_m - starts_m
    # any direction across the bar will do; the unit axis least parallel to it is safe
    least = np.eye(3)[np.argmin(np.abs(along), axis=1)]
    side = np.cross(along, least)
    side *= width_m / np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(along, side)
    other *= width_m / np.linalg.norm(other, axis=1, keepdims=True)
    i, j, k = _BOX_CORNERS.T[:, None, :, None]
    corners = starts_m[:, None] + i * side[:, None] + j * other[:, None] + k * along[:, None]
    triangles = _BOX_TRIANGLES + 8 * np.arange(len(starts_m))[:, None, None]
    return Mesh(corners.reshape(-1, 3), triangles.reshape(-1, 3))


@dataclass(frozen=True, slots=True)
class House:
    """A box with a gabled roof; ``azimuth_rad`` is that of its ridge."""

    east_m: float
    north_m: float
    floor_m: float
    length_m: float
    width_m: float
    eaves_m: float
    ridge_m: float
    azimuth_rad: float


def house_mesh(house: House) -> Mesh:
    """Walls and roof of a house; the walls start at ``floor_m``, heights count from there."""
    size = np.array([house.width_m, house.length_m, house.eaves_m])
    ridge = np.array(
        [[0.0, -0.5 * house.length_m, house.ridge_m], [0.0, 0.5 * house.length_m, house.ridge_m]]
    )
    local = np.vstack([_BOX_CORNERS * size, ridge])
    c, s = np.cos(house.azimuth_rad), np.sin(house.azimuth_rad)
    turned = local @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return Mesh(turned + np.array([house.east_m, house.north_m, house.floor_m]), _HOUSE_TRIANGLES)


def leaves(
    centre_m: NDArray[np.float64],
    radii_m: NDArray[np.float64],
    n: int,
    size_m: float,
    rng: np.random.Generator,
) -> Mesh:
    """Scatter ``n`` triangles of about ``size_m`` in an ellipsoid: a crown that beams partly pass."""
    inside = rng.normal(size=(n, 3))
    inside *= (rng.uniform(size=n) ** (1 / 3) / np.linalg.norm(inside, axis=1))[:, None]
    corners = (centre_m + radii_m * inside)[:, None] + rng.normal(scale=0.6 * size_m, size=(n, 3, 3))
    return Mesh(corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3))
