"""Polar records of a scanner, and their Cartesian coordinates."""

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.ingest.scan import box_of

FULL_CIRCLE_DEG: Final = 360.0
RIGHT_ANGLE_DEG: Final = 90.0
ROUNDING_DEG: Final = 1e-6
"""What a maker's rounding may add to the end of a range of angles."""


def cartesian_from_polar(polar: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cartesian coordinates of polar records, in the scanner frame.

    ``x = S cos(omega) cos(alpha)``, ``y = S cos(omega) sin(alpha)``, ``z = S sin(omega)``.

    Parameters
    ----------
    polar : (n, 3) array
        Range S (metres), horizontal angle alpha from x towards y and elevation omega above the horizon (degrees).

    Returns
    -------
    (n, 3) array
        x, y, z, metres.

    References
    ----------
    The paper, eq. 1.
    """
    range_m = polar[:, 0]
    alpha_rad, omega_rad = np.radians(polar[:, 1]), np.radians(polar[:, 2])
    points_m = np.empty_like(polar)
    np.multiply(range_m, np.sin(omega_rad), out=points_m[:, 2])
    level_m = range_m * np.cos(omega_rad)
    np.multiply(level_m, np.cos(alpha_rad), out=points_m[:, 0])
    np.multiply(level_m, np.sin(alpha_rad), out=points_m[:, 1])
    return points_m


def check_polar(path: Path, polar: NDArray[np.float64]) -> tuple[str, ...]:
    """Notes on polar records (n, 3) that are possible, but doubtful.

    Raises
    ------
    InputError
        If a range is negative, or an angle lies outside the circle or the elevations.
    """
    box = box_of(polar)
    low, high = box.low, box.high
    if low[0] < 0.0:
        raise InputError(
            f"{path}: needs ranges S >= 0, came {low[0]:g}; is the column S the range in metres?"
        )
    if max(-low[2], high[2]) > RIGHT_ANGLE_DEG + ROUNDING_DEG:
        raise InputError(
            f"{path}: needs elevations omega from -90 to 90 degrees, came {low[2]:g} to {high[2]:g}; "
            "a zenith angle is 90 degrees minus the elevation, and a gon is 0.9 degrees"
        )
    if max(-low[1], high[1]) > FULL_CIRCLE_DEG + ROUNDING_DEG:
        raise InputError(
            f"{path}: needs horizontal angles alpha from -360 to 360 degrees, came {low[1]:g} to {high[1]:g}; "
            "a gon is 0.9 degrees"
        )
    if max(-low[1], high[1]) <= 2.0 * np.pi and max(-low[2], high[2]) <= np.pi / 2.0:
        return ("all angles alpha and omega are small enough to be radians; degrees are taken",)
    return ()
