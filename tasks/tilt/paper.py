"""Equations 19 to 22 of the paper, of a direction that points up.

The angles are taken by atan2 of cross and dot product and not by arccos: of a direction printed with
eight digits the arccos of d_up = 0.9999 loses a tenth of an arc second, atan2 a thousandth.

References
----------
Zhou et al. 2025, Buildings 15, 3046, section 2.4.
"""

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError


def beta_deg(direction: NDArray[np.float64]) -> float:
    """Angle between the axis and the x axis, eq. 19 as printed.

    The paper calls it the tilt azimuth. It is not a horizontal direction: it stays within the tilt of
    90 degrees wherever the axis leans to. The direction of lean is ``TiltParameters.azimuth_deg``.

    Parameters
    ----------
    direction : (3,) array
        Direction of the axis (east, north, up), up above 0, of any length.

    Returns
    -------
    float
        Degrees, 0 to 180.

    Raises
    ------
    ShapeError
        If the direction is not three finite numbers with up above 0.
    """
    east, north, up = _upward(direction, "beta_deg")
    return float(np.degrees(np.arctan2(np.hypot(north, up), east)))


def beta_of_reversed_axis_deg(direction: NDArray[np.float64]) -> float:
    """Equation 19 of the reversed direction, -d: what table 2 of the paper prints, within 0.5 arc seconds.

    The vectors of table 2 point up and its azimuths belong to vectors that point down; the cause cannot
    be read from the paper. For comparison with the paper only.

    Parameters
    ----------
    direction : (3,) array
        Direction of the axis (east, north, up), up above 0, of any length.

    Returns
    -------
    float
        Degrees: 180 minus ``beta_deg``.

    Raises
    ------
    ShapeError
        If the direction is not three finite numbers with up above 0.
    """
    return 180.0 - beta_deg(direction)


def tilt_rad(direction: NDArray[np.float64]) -> float:
    """Angle between the axis and the vertical, eq. 20.

    Parameters
    ----------
    direction : (3,) array
        Direction of the axis (east, north, up), up above 0, of any length.

    Returns
    -------
    float
        Radians, 0 to pi/2.

    Raises
    ------
    ShapeError
        If the direction is not three finite numbers with up above 0.
    """
    east, north, up = _upward(direction, "tilt_rad")
    return float(np.arctan2(np.hypot(east, north), up))


def verticality(tilt_rad: float) -> float:
    """Tangent of the tilt, eq. 21, dimensionless (1000 times this is the permille of the tables)."""
    return float(np.tan(tilt_rad))


def deviation_m(height_m: float, verticality: float) -> float:
    """Horizontal offset at the height H of a straight axis with this verticality, eq. 22, metres.

    The line is carried on to H beyond the part that was sliced, and bending is ignored.
    """
    return height_m * verticality


def _upward(direction: NDArray[np.float64], asked_by: str) -> NDArray[np.float64]:
    d = np.asarray(direction, dtype=np.float64)
    if d.shape != (3,) or not np.isfinite(d).all() or d[2] <= 0.0:
        raise ShapeError(f"{asked_by} needs a finite direction (3,) with up above 0; got {direction!r}")
    return d
