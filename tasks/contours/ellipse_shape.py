"""An ellipse without a singular circle, and orthogonal distances from it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle_adjustment import WIDEST
from tasks.contours.robust_adjustment import Linearised, extent_of
from tasks.contours.straightening import StraightSection

FOOT_STEP: Final = 1e-14
"""A foot point whose direction turns by less than this has been found, radians."""

MOST_FOOT_STEPS: Final = 60
"""Steps to a foot point: points near an ellipse need 3 to 6, those near its evolute more."""


@dataclass(frozen=True, slots=True)
class Ellipse:
    """The points centre + S u over all unit vectors u, with S = [[mean + even, odd], [odd, mean - even]], metres.

    Half axes are mean +- hypot(even, odd). A circle has even = odd = 0 and is a point like any other: half axes and
    their direction would be singular there.
    """

    east_m: float
    north_m: float
    mean_m: float
    even_m: float
    odd_m: float

    @property
    def half_difference_m(self) -> float:
        """Half of the difference of the half axes, metres."""
        return float(np.hypot(self.even_m, self.odd_m))

    @property
    def major_m(self) -> float:
        """Larger half axis, metres."""
        return self.mean_m + self.half_difference_m

    @property
    def minor_m(self) -> float:
        """Smaller half axis, metres."""
        return self.mean_m - self.half_difference_m

    @property
    def major_angle_rad(self) -> float:
        """Direction of the larger axis in (-pi/2, pi/2], counter-clockwise from east."""
        return float(np.arctan2(self.odd_m, self.even_m) / 2)

    @property
    def parameters_m(self) -> NDArray[np.float64]:
        """The five numbers as an array (5,)."""
        return np.array([self.east_m, self.north_m, self.mean_m, self.even_m, self.odd_m])


def ellipse_of(parameters_m: NDArray[np.float64]) -> Ellipse:
    """The ellipse of parameters (5,)."""
    return Ellipse(*(float(value) for value in parameters_m))


@dataclass(frozen=True, slots=True, eq=False)
class EllipseShape:
    """Points of a slice against an ellipse, by orthogonal distances."""

    straight: StraightSection
    sigma: NDArray[np.float64]
    extent_m: float

    @classmethod
    def of(cls, straight: StraightSection, sigma: NDArray[np.float64]) -> "EllipseShape":
        """Take the extent from the points; ``sigma`` (n,) are relative standard deviations."""
        return cls(straight, sigma, extent_of(straight))

    def at(self, parameters_m: NDArray[np.float64]) -> Linearised | None:
        """Signed distances, outward positive; None where a half axis is not above 0 or the curve is a parabola.

        A point's widening is taken off its distance: the curve parallel to the ellipse is the one that it lies on.

        References
        ----------
        Ahn, Rauh & Warnecke 2001, Pattern Recognition 34 (orthogonal distances, Gauss-Newton).
        """
        ellipse = ellipse_of(parameters_m)
        if not (ellipse.minor_m > 0.0 and ellipse.major_m <= WIDEST * self.extent_m):
            return None
        cosine, sine = np.cos(ellipse.major_angle_rad), np.sin(ellipse.major_angle_rad)
        x, y = self.straight.xy_m[:, 0] - ellipse.east_m, self.straight.xy_m[:, 1] - ellipse.north_m
        along, across = cosine * x + sine * y, cosine * y - sine * x
        tx, ty = foot_directions(along, across, ellipse)
        nx, ny = tx / ellipse.major_m, ty / ellipse.minor_m
        length = np.sqrt(nx * nx + ny * ny)
        nx, ny = nx / length, ny / length
        distance = (along - ellipse.major_m * tx) * nx + (across - ellipse.minor_m * ty) * ny
        # back to east and north: u is the unit vector of the foot point, n the outward normal there
        ux, uy = cosine * tx - sine * ty, sine * tx + cosine * ty
        nx, ny = cosine * nx - sine * ny, sine * nx + cosine * ny
        jacobian = -np.array([nx, ny, nx * ux + ny * uy, nx * ux - ny * uy, nx * uy + ny * ux])
        return Linearised((distance - self.straight.widening_m) / self.sigma, jacobian / self.sigma)


def foot_directions(
    along_m: NDArray[np.float64], across_m: NDArray[np.float64], ellipse: Ellipse
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit vectors (n,), (n,) u in the frame of the axes whose points S u are nearest to points (n,), (n,).

    The ellipse is replaced by its circle of curvature at the foot point of before, on the side of the point.
    """
    a, b = ellipse.major_m, ellipse.minor_m
    x, y = np.abs(along_m), np.abs(across_m)
    tiny = np.finfo(float).tiny
    # a start on an axis would stay there, so all start between them
    tx, ty = np.full_like(x, np.sqrt(0.5)), np.full_like(y, np.sqrt(0.5))
    difference = a * a - b * b
    for _ in range(MOST_FOOT_STEPS):
        middle_x, middle_y = difference * tx**3 / a, -difference * ty**3 / b
        radius = np.sqrt((a * tx - middle_x) ** 2 + (b * ty - middle_y) ** 2)
        reach = np.maximum(np.sqrt((x - middle_x) ** 2 + (y - middle_y) ** 2), tiny)
        new_x = np.clip(((x - middle_x) * radius / reach + middle_x) / a, 0.0, 1.0)
        new_y = np.clip(((y - middle_y) * radius / reach + middle_y) / b, 0.0, 1.0)
        length = np.maximum(np.sqrt(new_x**2 + new_y**2), tiny)
        new_x, new_y = new_x / length, new_y / length
        turned = float(np.abs(new_x * ty - new_y * tx).max())
        tx, ty = new_x, new_y
        if turned <= FOOT_STEP:
            break
    return np.copysign(tx, along_m), np.copysign(ty, across_m)
