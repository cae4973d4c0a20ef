"""What horizontal cuts of a leaning cone do to the lean of its axis."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError


@dataclass(frozen=True, slots=True, eq=False)
class UprightLean:
    """Lean vector (2,) of an axis and its covariance (2, 2)."""

    lean: NDArray[np.float64]
    covariance: NDArray[np.float64]


def cone_cut_factor(taper: float, tilt_rad: float) -> float:
    """Factor by which the centres of horizontal cuts lean more than the axis of a cone with round normal sections.

    ``taper`` is the change of the radius over a metre of the axis, of either sign. The cuts are ellipses and their
    centres lie on a line through the apex, with the slope tan(tilt) times (1 + k^2) / (1 - k^2 tan^2(tilt)).

    Raises
    ------
    InputError
        If a horizontal plane does not cut the cone in an ellipse: k tan(tilt) is 1 or more.
    """
    flat = taper * np.tan(tilt_rad)
    if not abs(flat) < 1.0:
        raise InputError(
            f"a horizontal cut of a cone is an ellipse where taper times tan(tilt) is below 1, got {flat:g}"
        )
    return float((1.0 + taper**2) / (1.0 - flat**2))


def take_out_cone_cut(
    lean: NDArray[np.float64], covariance: NDArray[np.float64], taper: float
) -> UprightLean:
    """Lean of the axis of a cone from that of the centres of its horizontal cuts, with its covariance.

    The taper counts as known: its own error moves the lean by 2 k dk of itself.

    Parameters
    ----------
    lean : (2,) array
        Lean vector of the centres.
    covariance : (2, 2) array
        Its covariance.
    taper : float
        Change of the radius over a metre of the axis, of either sign, dimensionless.
    """
    square = taper**2
    root = np.sqrt((1.0 + square) ** 2 + 4.0 * square * float(lean @ lean))
    factor = 2.0 / (1.0 + square + root)
    # derivative of the factor by the lean: along the lean only
    turn = factor * np.eye(2) - 2.0 * square * factor**2 / root * np.outer(lean, lean)
    return UprightLean(factor * lean, turn @ covariance @ turn.T)
