"""How far off the surface each point may lie: range, angle and roughness along its line of sight."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.preprocessing import ShaftModel

ROUGHNESS_M: Final = 0.003
"""Standard deviation of a concrete or brick face about its smooth surface, metres."""

STATED_AT_M: Final = 100.0
"""Range at which a maker's range sigma is stated, metres."""

LEAST_PART: Final = 0.5
"""Range noise is in proportion to the range, but never below this part of what is stated."""


@dataclass(frozen=True, slots=True)
class ScannerNoise:
    """What the maker states of the scanner, and how rough the surface is.

    ``range_sigma_m`` is the standard deviation of a range at 100 m, metres, ``angle_sigma_rad`` that of an angle,
    ``roughness_m`` that of the face about its smooth surface, metres.
    """

    range_sigma_m: float
    angle_sigma_rad: float
    roughness_m: float = ROUGHNESS_M


def sight_sigmas(
    points_m: NDArray[np.float64],
    station_index: NDArray[np.integer],
    positions_m: NDArray[np.float64],
    model: ShaftModel,
    noise: ScannerNoise,
) -> NDArray[np.float64]:
    """Standard deviation (n,) of every point across the surface of the shaft, metres.

    sigma_n^2 = sigma_rho^2 cos^2 i + (sigma_alpha d)^2 sin^2 i + roughness^2, with the range sigma_rho at the distance
    d and the angle i between the line of sight and the normal of the rough shaft: its axis with lean and bend, its
    taper. How far a point lies off the rough surface does not matter, only where about the axis it lies.

    Parameters
    ----------
    points_m : (n, 3) array
        Points of the shaft, site frame, metres.
    station_index : (n,) array
        Which of the stations saw each.
    positions_m : (k, 3) array
        Positions of the stations, site frame, metres.
    model : ShaftModel
        The rough shaft.
    noise : ScannerNoise
        Of all stations alike.

    Raises
    ------
    ShapeError
        If shapes disagree, or a station index is out of range.
    """
    _check(points_m, station_index, positions_m)
    from tasks.sight_kernel import add_sights  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    sigma_m = np.empty(len(points_m))
    knots_z_m = np.array(model.radius_z_m)
    axis = np.vstack([model.axis_at(knots_z_m).T, model.radius_at(knots_z_m)])
    slopes = np.diff(axis, axis=1) / np.diff(knots_z_m)
    scanner = (noise.range_sigma_m, STATED_AT_M, LEAST_PART, noise.angle_sigma_rad, noise.roughness_m)
    add_sights(points_m, station_index, positions_m, knots_z_m, axis, slopes, scanner, sigma_m)
    return sigma_m


def _check(
    points_m: NDArray[np.float64], station_index: NDArray[np.integer], positions_m: NDArray[np.float64]
) -> None:
    shapes = (points_m.shape, station_index.shape, positions_m.shape)
    if points_m.ndim != 2 or shapes != ((len(points_m), 3), (len(points_m),), (len(positions_m), 3)):
        raise ShapeError(
            "sight_sigmas needs points (n, 3), a station each (n,) and positions (k, 3); "
            f"got {points_m.shape}, {station_index.shape} and {positions_m.shape}"
        )
    if len(points_m) and not 0 <= int(station_index.min()) <= int(station_index.max()) < len(positions_m):
        raise ShapeError(
            f"sight_sigmas needs station indices below {len(positions_m)}; got {station_index.max()}"
        )
