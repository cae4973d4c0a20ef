"""Frames, axes, signs and units: said once, here.

Frame ``site``: x east, y north, z up, metres, right-handed, origin near the foot of the structure.
Frame ``scanner``: of one set-up; z plumb within the level sigma, origin at the scanner's centre.
Heading: azimuth of the scanner's own +y axis, clockwise from grid north (+y of ``site``).
Azimuth: clockwise from grid north, 0 <= azimuth < 360 degrees.
Lean vector: (d_e / d_u, d_n / d_u) of the axis direction d with d_u > 0, dimensionless.
Inside, lengths are metres and angles radians; degrees only in names that end in ``_deg``.
A pose is T_site_scanner: points_site = rotation @ points_scanner + position.
Pose parameters, in this order wherever six numbers stand for a pose: rotation about east, north, up
(radians, small, applied on the left about the scanner's origin), then shift east, north, up (metres).
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

ARCSEC_RAD: Final = np.pi / (180.0 * 3600.0)
"""One second of arc in radians."""

PARAMETERS_PER_STATION: Final = 6
"""Rotations about east, north, up, then shifts east, north, up."""


def rotation_site_scanner(heading_rad: float) -> NDArray[np.float64]:
    """Rotation of a levelled scanner's axes into the site frame.

    The scanner's +y axis points to azimuth ``heading_rad`` (clockwise from north), its +z axis up.

    Returns
    -------
    (3, 3) array
        ``points_site = R @ points_scanner`` up to the shift.
    """
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def azimuth_deg(east: float, north: float) -> float:
    """Azimuth of a horizontal vector, clockwise from grid north, 0 <= azimuth < 360 degrees."""
    # a second remainder, because a tiny negative angle plus 360 rounds to 360
    return float(np.degrees(np.arctan2(east, north)) % 360.0 % 360.0)
