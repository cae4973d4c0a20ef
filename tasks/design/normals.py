"""Normal equations of a plan: axis, radius profile and poses together, each station's part on its own.

The unknowns are the axis (east, half-length times lean east, north, half-length times lean north), the radius of every
band, and six pose errors a station in the order of ``tasks.conventions``. The radii are eliminated band by band.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION
from tasks.design.shaft import CELLS_ROUND, Cells
from tasks.design.sight import Site, View

AXIS: Final = 4
LEAN_ROWS: Final = (1, 3)
"""Places of the lean among the unknowns of the axis."""

PATCH_M: Final = 5.0
PATCHES_ROUND: Final = 36
"""A patch of 5 m by 10 degrees is as far as a dent or a bulge goes."""


@dataclass(frozen=True, slots=True)
class StationNormals:
    """The part of one station, over its own ten unknowns (axis and pose) and the radii.

    ``core`` (10, 10) is summed over all bands; ``to_radius`` (b, 10) and ``radius`` (b,) join it to the radii.
    ``patches`` (b, PATCHES_ROUND, 11) is what a unit offset of the surface there does to the right side, the radius last.
    """

    core: NDArray[np.float64]
    to_radius: NDArray[np.float64]
    radius: NDArray[np.float64]
    patches: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Joined:
    """All stations together with the radii eliminated: unknowns are the axis, then the pose of each station.

    ``matrix`` (4 + 6 n, 4 + 6 n); ``form`` (patches, 4 + 6 n) is the right side of a unit offset of each patch.
    """

    matrix: NDArray[np.float64]
    form: NDArray[np.float64]


def station_normals(cells: Cells, site: Site, view: View) -> StationNormals:
    """Sum up what the points of a station say of axis, radii and its own pose."""
    columns = _derivatives(cells, site)
    # distances are counted horizontally, noise across the surface
    steepness = np.linalg.norm(cells.gradient, axis=2)
    weights = view.counts / (view.sigma_m * steepness) ** 2
    weighted = columns * weights[..., None]
    full = np.einsum("bsi,bsj->bij", weighted, columns, optimize=True)
    per_patch = CELLS_ROUND // PATCHES_ROUND
    patches = weighted.reshape(len(weighted), PATCHES_ROUND, per_patch, -1).sum(axis=2)
    return StationNormals(full[:, :-1, :-1].sum(axis=0), full[:, :-1, -1], full[:, -1, -1], patches)


def join(parts: Sequence[StationNormals], cells: Cells) -> Joined:
    """Add the parts of the stations and eliminate the radius of every band."""
    size = AXIS + PARAMETERS_PER_STATION * len(parts)
    bands = len(cells.bands.z_m)
    matrix, to_radius = np.zeros((size, size)), np.zeros((bands, size))
    patches = np.zeros((bands, PATCHES_ROUND, size))
    for number, part in enumerate(parts):
        own = _places(number)
        matrix[np.ix_(own, own)] += part.core
        to_radius[:, own] += part.to_radius
        patches[..., own] += part.patches[..., :-1]
    radius = np.sum([part.radius for part in parts], axis=0)
    # a band that nobody sees has no radius to find
    mean = np.divide(to_radius, radius[:, None], out=np.zeros_like(to_radius), where=radius[:, None] > 0.0)
    on_radius = np.sum([part.patches[..., -1] for part in parts], axis=0)
    patches -= on_radius[..., None] * mean[:, None]
    above_m = cells.bands.z_m - cells.shaft.z_m[0]
    _, patch = np.unique(np.floor(above_m / PATCH_M), return_inverse=True)
    form = np.zeros((patch.max() + 1, PATCHES_ROUND, size))
    np.add.at(form, patch, patches)
    return Joined(matrix - to_radius.T @ mean, form.reshape(-1, size))


def half_length_m(cells: Cells) -> float:
    """What the lean is multiplied with among the unknowns."""
    return cells.shaft.length_m / 2.0


def _places(number: int) -> NDArray[np.intp]:
    first = AXIS + PARAMETERS_PER_STATION * number
    return np.concatenate([np.arange(AXIS), np.arange(first, first + PARAMETERS_PER_STATION)])


def _derivatives(cells: Cells, site: Site) -> NDArray[np.float64]:
    """Derivatives (b, CELLS_ROUND, 11) of the distance from the surface by axis, pose and radius."""
    arm_m = cells.points_m - np.asarray(site.position_m)
    high = (cells.bands.z_m - np.mean(cells.shaft.z_m))[:, None] / half_length_m(cells)
    east, north = cells.gradient[..., 0], cells.gradient[..., 1]
    axis = np.stack([east, high * east, north, high * north], axis=2)
    # q . (w x arm) = w . (arm x q)
    rotation = np.cross(arm_m, cells.gradient)
    return np.concatenate([axis, rotation, cells.gradient, np.ones((*east.shape, 1))], axis=2)
