"""What an ovality that an arc does not show does to the centre of its circle."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.profile import Harmonics
from tasks.contours.robust_adjustment import RobustFit
from tasks.contours.straightening import StraightSection

BUILT_OVALITY: Final = 1e-3
"""Standard deviation of each coefficient of the second harmonic of a shaft taken for round, as a part of its radius.

A choice, not a measurement: 4 mm on a shaft of 4 m. At two standard deviations, 8 mm, the largest and the smallest
diameter differ by 32 mm, 0.4 % of the diameter. A shaft that is less round than that needs an arc that shows it.
"""


def unseen_ovality_m2(
    straight: StraightSection, circle: RobustFit, beforehand: float = BUILT_OVALITY
) -> NDArray[np.float64]:
    """Mean square (2, 2) of the shift of a circle's centre by the ovality of its shaft, square metres.

    A second harmonic (a, b) shifts the centre of the circle by G (a, b), with G from the directions of the points: per
    metre of ovality up to 1.3 m on 240 degrees, 2.2 on 180, 3.1 on 120 where its axis points along the bisector of the
    arc, 0.4, 0.9, 1.4 at 45 degrees from it, and 0 on a full ring. What is known of (a, b)
    after the fit is a mean m and a covariance P, from the points and a prior with standard deviation ``beforehand``, a
    part of the radius; the mean square is G (m m' + P) G'. Where the points see the ovality P is small, and the term
    with it.
    """
    used = circle.used
    east, north = (straight.xy_m[used] - circle.parameters_m[:2]).T
    turn = np.exp(1j * np.arctan2(north, east))
    # the derivatives of a circle carry the weights of the points: row 2 is -1 / sigma
    shape = Harmonics(2).rows(turn).values * circle.jacobian[2, used]
    base = circle.jacobian[:, used]
    cross = base @ shape.T
    to_circle = -np.linalg.solve(circle.normal, cross)
    left = shape @ shape.T + cross.T @ to_circle
    prior = circle.variance_m2 / (beforehand * circle.parameters_m[2]) ** 2
    inverse = np.linalg.inv(left + prior * np.eye(2))
    gradient = shape @ circle.residuals_m[used] + to_circle.T @ (base @ circle.residuals_m[used])
    mean = -inverse @ gradient
    known = circle.variance_m2 * inverse + np.outer(mean, mean)
    shift = to_circle[:2]
    return np.asarray(shift @ known @ shift.T)
