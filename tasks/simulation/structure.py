"""The structure as meshes: shaft, platform and ladder."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.simulation.mesh import Mesh, Surface, beams, merge, tube
from tasks.simulation.shape import ShaftShape
from tasks.simulation.wall import BELOW_GROUND_M, CHORD_TOLERANCE_M, Wall, wall_mesh

_RING_STEP_M: Final = 2.0
_RAIL_SEGMENT_M: Final = 3.0
_PLATFORM_CORNERS: Final = 48


@dataclass(frozen=True, slots=True)
class Fittings:
    """What hangs on the shaft; heights above the foot.

    The ladder stands before the shaft towards ``ladder_azimuth_deg``, from ``ladder_foot_m`` to the platform.
    """

    platform_z_m: float = 102.1
    platform_width_m: float = 1.2
    platform_thickness_m: float = 0.15
    handrail_m: float = 1.1
    ladder_azimuth_deg: float = 120.0
    ladder_foot_m: float = 2.6
    ladder_width_m: float = 0.5
    ladder_standoff_m: float = 0.2
    rung_spacing_m: float = 0.3


def structure_meshes(
    shape: ShaftShape, fittings: Fittings, wall: Wall | None = None
) -> list[tuple[Surface, Mesh]]:
    """Meshes of the shaft and of what hangs on it, site frame; without ``wall`` it is smooth and round.

    A platform that lies above the top of the shaft is left out, and the ladder then ends 1 m below the top.
    """
    meshes = [(Surface.SHAFT, shaft_mesh(shape) if wall is None else wall_mesh(shape, wall))]
    has_platform = fittings.platform_z_m < shape.height_m
    top_m = fittings.platform_z_m if has_platform else shape.height_m - 1.0
    if has_platform:
        meshes.append((Surface.PLATFORM, platform_mesh(shape, fittings)))
    if fittings.ladder_foot_m + _RAIL_SEGMENT_M < top_m:
        meshes.append((Surface.LADDER, ladder_mesh(shape, fittings, top_m)))
    return meshes


def shaft_mesh(shape: ShaftShape) -> Mesh:
    """Skin of the shaft, nowhere further than about ``CHORD_TOLERANCE_M`` inside the round surface."""
    widest_m = max(shape.radius_foot_m, shape.radius_top_m) + abs(shape.taper_bow_m)
    n = int(np.ceil(np.pi / np.arccos(1.0 - CHORD_TOLERANCE_M / widest_m)))
    z_m = np.linspace(
        -BELOW_GROUND_M, shape.height_m, int(np.ceil((shape.height_m + BELOW_GROUND_M) / _RING_STEP_M)) + 1
    )
    azimuth_rad = np.arange(n) * 2.0 * np.pi / n
    reach_m = shape.radius_at(z_m)[:, None] * shape.roundness_at(azimuth_rad)
    across_east, across_north = _section_axes(shape, z_m)
    rings = np.concatenate([shape.axis_at(z_m), z_m[:, None]], axis=1)[:, None, :]
    rings = rings + (reach_m * np.sin(azimuth_rad))[..., None] * across_east[:, None]
    return tube(rings + (reach_m * np.cos(azimuth_rad))[..., None] * across_north[:, None])


def platform_mesh(shape: ShaftShape, fittings: Fittings) -> Mesh:
    """A ring around the shaft with a handrail of posts and two bars."""
    z_m = fittings.platform_z_m
    outer_m = float(shape.radius_at(np.array(z_m))) * (1.0 + abs(shape.ovality)) + fittings.platform_width_m
    floor_m = z_m + fittings.platform_thickness_m
    profile = [(0.8 * outer_m, z_m), (outer_m, z_m), (outer_m, floor_m), (0.3 * outer_m, floor_m)]
    floor = tube(np.stack([_ring(shape, radius_m, height_m) for radius_m, height_m in profile]))
    feet = _ring(shape, outer_m - 0.05, floor_m)
    rail = np.array([0.0, 0.0, fittings.handrail_m])
    bars = []
    for share in (0.5, 1.0):
        bar = feet + share * rail
        bars.append(beams(bar, np.roll(bar, -1, axis=0), 0.04))
    posts = beams(feet[::3], feet[::3] + rail, 0.05)
    return merge([floor, posts, *bars])


def ladder_mesh(shape: ShaftShape, fittings: Fittings, top_m: float) -> Mesh:
    """Two rails and their rungs before the shaft."""
    length_m = top_m - fittings.ladder_foot_m
    rail_z_m = np.linspace(fittings.ladder_foot_m, top_m, int(np.ceil(length_m / _RAIL_SEGMENT_M)) + 1)
    rung_z_m = np.arange(fittings.ladder_foot_m + 0.15, top_m, fittings.rung_spacing_m)
    half_m = 0.5 * fittings.ladder_width_m
    rails = [_ladder_line(shape, fittings, rail_z_m, side_m) for side_m in (-half_m, half_m)]
    rungs = [_ladder_line(shape, fittings, rung_z_m, side_m) for side_m in (-half_m, half_m)]
    return merge([*(beams(rail[:-1], rail[1:], 0.06) for rail in rails), beams(rungs[0], rungs[1], 0.03)])


def _section_axes(
    shape: ShaftShape, z_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit vectors (k, 3) of the section planes, near east and near north."""
    across_east = np.tile([1.0, 0.0, 0.0], (len(z_m), 1))
    across_north = np.tile([0.0, 1.0, 0.0], (len(z_m), 1))
    if shape.sections == "horizontal":
        return across_east, across_north
    along = np.concatenate([shape.slope_at(z_m), np.ones((len(z_m), 1))], axis=1)
    across_east = np.cross(across_north, along)
    across_east /= np.linalg.norm(across_east, axis=1, keepdims=True)
    across_north = np.cross(along, across_east)
    return across_east, across_north / np.linalg.norm(across_north, axis=1, keepdims=True)


def _ring(shape: ShaftShape, radius_m: float, z_m: float) -> NDArray[np.float64]:
    azimuth_rad = np.arange(_PLATFORM_CORNERS) * 2.0 * np.pi / _PLATFORM_CORNERS
    east_m, north_m = shape.axis_at(np.array(z_m))
    return np.column_stack(
        [
            east_m + radius_m * np.sin(azimuth_rad),
            north_m + radius_m * np.cos(azimuth_rad),
            np.full(_PLATFORM_CORNERS, z_m),
        ]
    )


def _ladder_line(
    shape: ShaftShape, fittings: Fittings, z_m: NDArray[np.float64], side_m: float
) -> NDArray[np.float64]:
    """Points (k, 3) before the shaft at heights ``z_m``, ``side_m`` beside the ladder's azimuth."""
    azimuth_rad = np.radians(fittings.ladder_azimuth_deg)
    out = np.array([np.sin(azimuth_rad), np.cos(azimuth_rad)])
    along = np.array([np.cos(azimuth_rad), -np.sin(azimuth_rad)])
    reach_m = shape.radius_at(z_m) * shape.roundness_at(azimuth_rad) + fittings.ladder_standoff_m
    return np.column_stack([shape.axis_at(z_m) + reach_m[:, None] * out + side_m * along, z_m])
