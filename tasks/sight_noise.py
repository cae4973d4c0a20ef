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

CHUNK: Final = 65_536
"""Points that are worked on at once: what is made of them on the way stays in the processor's cache."""


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
    sigma_m = np.empty(len(points_m))
    axis = _axis_of(model)
    for start in range(0, len(points_m), CHUNK):
        rows = slice(start, start + CHUNK)
        sigma_m[rows] = _sigmas(points_m[rows], positions_m[station_index[rows]], axis, noise)
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


@dataclass(frozen=True, slots=True)
class _Axis:
    """The axis of a shaft between its knots: ``values`` (3, k) are east, north and radius there, metres."""

    knots_z_m: NDArray[np.float64]
    values: NDArray[np.float64]

    @property
    def slopes(self) -> NDArray[np.float64]:
        """Lean east, lean north and taper (3, k - 1) between the knots."""
        return np.asarray(np.diff(self.values, axis=1) / np.diff(self.knots_z_m))


def _axis_of(model: ShaftModel) -> _Axis:
    knots = np.array(model.radius_z_m)
    return _Axis(knots, np.vstack([model.axis_at(knots).T, model.radius_at(knots)]))


def _sigmas(
    points_m: NDArray[np.float64],
    scanners_m: NDArray[np.float64],
    axis: _Axis,
    noise: ScannerNoise,
) -> NDArray[np.float64]:
    """Sigmas (n,) of points (n, 3) seen from (n, 3)."""
    east, north, up = points_m.T
    knot = np.clip(np.searchsorted(axis.knots_z_m, up, side="right") - 1, 0, len(axis.knots_z_m) - 2)
    lean_east, lean_north, taper = axis.slopes[:, knot]
    above = up - axis.knots_z_m[knot]
    out_east = east - axis.values[0, knot] - above * lean_east
    out_north = north - axis.values[1, knot] - above * lean_north
    # a point on the axis itself has no normal: 0 / tiny makes it level, and its sigma that of a grazing sight
    out = np.maximum(np.hypot(out_east, out_north), np.finfo(float).tiny)
    # gradient of |p - c(z)| - R(z): the outward normal of a leaning, tapering shaft, not yet of length one
    rising = -(out_east * lean_east + out_north * lean_north) / out - taper
    sight_east, sight_north, sight_up = (points_m - scanners_m).T
    distance_2 = sight_east**2 + sight_north**2 + sight_up**2
    along = (out_east * sight_east + out_north * sight_north) / out + rising * sight_up
    cos_2 = np.minimum(along**2 / ((1.0 + rising**2) * distance_2), 1.0)
    range_2 = noise.range_sigma_m**2 * np.maximum(distance_2 / STATED_AT_M**2, LEAST_PART**2)
    across_2 = noise.angle_sigma_rad**2 * distance_2
    return np.asarray(np.sqrt(range_2 * cos_2 + across_2 * (1.0 - cos_2) + noise.roughness_m**2))
