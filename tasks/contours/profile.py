"""A radius profile r(theta) about a centre, linear in its coefficients."""

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from tasks.contours.circle import Circle
from tasks.contours.circle_adjustment import WIDEST
from tasks.contours.robust_adjustment import Linearised, extent_of
from tasks.contours.straightening import StraightSection

INNERMOST: Final = 0.01
"""Points nearer to the centre than this part of the extent turn the direction no further: they have no weight."""


@dataclass(frozen=True, slots=True, eq=False)
class BasisRows:
    """Functions (count, n) in n directions and their derivatives (count, n), per radian."""

    values: NDArray[np.float64]
    slopes: NDArray[np.float64]


class Basis(Protocol):
    """Functions of the direction that make a profile out of round; none has a first harmonic."""

    @property
    def count(self) -> int:
        """How many functions."""
        ...

    def rows(self, turn: NDArray[np.complex128]) -> BasisRows:
        """Functions in directions given as unit numbers (n,), east real and north imaginary."""
        ...


@dataclass(frozen=True, slots=True)
class Harmonics:
    """cos k theta and sin k theta for k = 2 to ``order``; order 0 is a circle."""

    order: int

    @property
    def count(self) -> int:
        """Two functions for every harmonic."""
        return 2 * max(self.order - 1, 0)

    @property
    def numbers(self) -> NDArray[np.float64]:
        """The k (count,) of every function."""
        return np.repeat(np.arange(2.0, self.order + 1.0), 2)

    def rows(self, turn: NDArray[np.complex128]) -> BasisRows:
        """Rows cos 2 theta, sin 2 theta, cos 3 theta, ..."""
        values = np.empty((self.count, len(turn)))
        slopes = np.empty_like(values)
        power = turn
        for row in range(0, self.count, 2):
            power = power * turn
            k = row // 2 + 2
            values[row], values[row + 1] = power.real, power.imag
            slopes[row], slopes[row + 1] = -k * power.imag, k * power.real
        return BasisRows(values, slopes)


@dataclass(frozen=True, slots=True, eq=False)
class ProfileShape:
    """Points of a slice against a profile; parameters are east, north, radius and the coefficients of the basis."""

    straight: StraightSection
    sigma: NDArray[np.float64]
    basis: Basis
    extent_m: float

    @classmethod
    def of(cls, straight: StraightSection, sigma: NDArray[np.float64], basis: Basis) -> "ProfileShape":
        """Take the extent from the points; ``sigma`` (n,) are relative standard deviations."""
        return cls(straight, sigma, basis, extent_of(straight))

    def at(self, parameters_m: NDArray[np.float64]) -> Linearised | None:
        """Radial residuals; None where the radius is not above 0 or the curve is a straight line."""
        east, north, radius = parameters_m[:3]
        if not 0.0 < radius <= WIDEST * self.extent_m:
            return None
        x, y = self.straight.xy_m[:, 0] - east, self.straight.xy_m[:, 1] - north
        distance = np.sqrt(x * x + y * y)
        length = np.maximum(distance, INNERMOST * self.extent_m)
        cosine, sine = x / length, y / length
        jacobian = np.empty((3 + self.basis.count, len(x)))
        jacobian[0], jacobian[1], jacobian[2] = -cosine, -sine, -1.0
        residuals = distance - self.straight.widening_m - radius
        if self.basis.count:
            rows, coefficients = self.basis.rows(cosine + 1j * sine), parameters_m[3:]
            turning = coefficients @ rows.slopes / length
            residuals -= coefficients @ rows.values
            jacobian[0] -= turning * sine
            jacobian[1] += turning * cosine
            jacobian[3:] = -rows.values
        residuals /= self.sigma
        jacobian /= self.sigma
        return Linearised(residuals, jacobian)


def profile_start(circle: Circle, basis: Basis) -> NDArray[np.float64]:
    """Parameters (3 + count,) of a circle as a profile, metres."""
    return np.concatenate([[circle.east_m, circle.north_m, circle.radius_m], np.zeros(basis.count)])
