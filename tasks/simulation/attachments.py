"""What stands at, hangs on or grows out of a structure besides ladder and platform: none of it is the shaft."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.simulation.mesh import House, Mesh, Surface, beams, house_mesh, leaves, merge
from tasks.simulation.shape import ShaftShape
from tasks.simulation.structure import Fittings, platform_mesh

_BRANCHES_SEED: Final = 20250315
"""Branches are those of one tree: the same in every epoch and campaign."""

_BRANCH_RISE: Final = 0.35
_BRANCH_WIDTH_M: Final = 0.03
_TWIGS: Final = 12
_TWIG_M: Final = 0.08


@dataclass(frozen=True, slots=True)
class Annex:
    """A box that touches the structure, towards an azimuth: it hides a part of the wall and looks like one."""

    azimuth_deg: float
    width_m: float
    height_m: float


@dataclass(frozen=True, slots=True)
class Antenna:
    """A panel that stands off the wall."""

    z_m: float
    azimuth_deg: float
    tall_m: float
    standoff_m: float


@dataclass(frozen=True, slots=True)
class Attachments:
    """Everything besides ladder and platform; heights above the foot, metres.

    ``platforms_m`` holds heights and widths of more platforms, ``plinth_m`` half side and height of a square foot.
    ``legs`` columns carry the wall from the ground to ``legs_top_m``. ``branches`` grow from ``branches_from_m`` on.
    """

    platforms_m: tuple[tuple[float, float], ...] = ()
    annex: Annex | None = None
    antennas: tuple[Antenna, ...] = ()
    plinth_m: tuple[float, float] | None = None
    legs: int = 0
    legs_top_m: float = 0.0
    branches: int = 0
    branches_from_m: float = 0.0


def attachment_meshes(
    shape: ShaftShape, fittings: Fittings, attached: Attachments
) -> list[tuple[Surface, Mesh]]:
    """Meshes of all that is attached, site frame."""
    platforms = [
        platform_mesh(shape, replace(fittings, platform_z_m=z_m, platform_width_m=width_m))
        for z_m, width_m in attached.platforms_m
    ]
    made = (
        (Surface.PLATFORM, platforms),
        (Surface.BUILDING, [*_annex(shape, attached.annex), *_plinth(shape, attached.plinth_m)]),
        (Surface.FURNITURE, [*_antennas(shape, attached.antennas), *_legs(shape, attached)]),
        (Surface.VEGETATION, _branches(shape, attached)),
    )
    return [(surface, merge(meshes)) for surface, meshes in made if meshes]


def _annex(shape: ShaftShape, annex: Annex | None) -> list[Mesh]:
    if annex is None:
        return []
    azimuth_rad = np.radians(annex.azimuth_deg)
    off_m = shape.radius_foot_m + 0.5 * annex.width_m
    east_m, north_m = shape.base_m.as_array() + off_m * np.array([np.sin(azimuth_rad), np.cos(azimuth_rad)])
    tall_m = annex.height_m + 1.0
    box = House(east_m, north_m, -1.0, annex.width_m, annex.width_m, tall_m, tall_m + 0.3, float(azimuth_rad))
    return [house_mesh(box)]


def _plinth(shape: ShaftShape, plinth_m: tuple[float, float] | None) -> list[Mesh]:
    if plinth_m is None:
        return []
    half_m, tall_m = plinth_m
    east_m, north_m = shape.base_m.as_array().tolist()
    box = House(
        east_m, north_m, -1.0, 2.0 * half_m, 2.0 * half_m, tall_m + 1.0, tall_m + 1.02, np.radians(20.0)
    )
    return [house_mesh(box)]


def _antennas(shape: ShaftShape, antennas: Sequence[Antenna]) -> list[Mesh]:
    made = []
    for antenna in antennas:
        place_m = _before(shape, np.array([antenna.z_m]), antenna.azimuth_deg, antenna.standoff_m)
        up_m = np.array([0.0, 0.0, antenna.tall_m])
        wall_m = _before(shape, np.array([antenna.z_m + 0.5 * antenna.tall_m]), antenna.azimuth_deg, 0.0)
        made += [beams(place_m, place_m + up_m, 0.25), beams(wall_m, place_m + 0.5 * up_m, 0.05)]
    return made


def _legs(shape: ShaftShape, attached: Attachments) -> list[Mesh]:
    if attached.legs == 0:
        return []
    feet = np.vstack(
        [
            _before(shape, np.array([-0.5]), azimuth_deg, -0.4)
            for azimuth_deg in np.arange(attached.legs) * 360.0 / attached.legs
        ]
    )
    tops = feet.copy()
    tops[:, 2] = attached.legs_top_m
    return [beams(feet, tops, 0.5)]


def _branches(shape: ShaftShape, attached: Attachments) -> list[Mesh]:
    """Branches that rise outwards, denser towards the top, with some leaves at their ends."""
    if attached.branches == 0:
        return []
    rng = np.random.default_rng(_BRANCHES_SEED)
    share = np.sqrt(rng.uniform(size=attached.branches))
    z_m = attached.branches_from_m + share * (shape.height_m - attached.branches_from_m)
    made = []
    for height_m, azimuth_deg in zip(z_m, rng.uniform(0.0, 360.0, attached.branches), strict=True):
        length_m = rng.uniform(0.3, 0.15 * shape.height_m)
        start_m = _before(shape, np.array([height_m]), azimuth_deg, -0.02)
        end_m = _before(shape, np.array([height_m]), azimuth_deg, length_m)
        end_m[:, 2] += _BRANCH_RISE * length_m
        made += [
            beams(start_m, end_m, _BRANCH_WIDTH_M),
            leaves(end_m[0], np.full(3, 0.4 * length_m), _TWIGS, _TWIG_M, rng),
        ]
    return made


def _before(
    shape: ShaftShape, z_m: NDArray[np.float64], azimuth_deg: float, off_m: float
) -> NDArray[np.float64]:
    """Points (k, 3) that are ``off_m`` outside the wall towards an azimuth."""
    azimuth_rad = np.radians(azimuth_deg)
    out = np.array([np.sin(azimuth_rad), np.cos(azimuth_rad)])
    reach_m = shape.radius_at(z_m)[:, None] + off_m
    return np.column_stack([shape.axis_at(z_m) + reach_m * out, z_m])
