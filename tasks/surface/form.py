"""What a surface may do: an axis that bends, a radius that changes with height, sections that are not quite round.

    distance of a point from the axis = R(z) + sum over k >= 2 of a_k(z) cos(k t) + b_k(z) sin(k t)

with t the direction from the axis, counterclockwise from east. The axis and the a_k, b_k are Legendre polynomials of the
height over the shaft, so the first coefficient of the axis is the slope of the line that fits it best, uniformly over
the shaft, whatever the density of the points. R is a cubic spline with even knots, or a polynomial of order 0 or 1.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

SPLINE_DEGREE: Final = 3

FIRST_HARMONIC: Final = 2
"""The first harmonic of a radius is a shift of the centre, and so belongs to the axis."""


STRAIGHT_ON: Final = 1e-6
"""Step from an end, as a part of half the height, over which its slope is taken."""


def _splines(share: NDArray[np.float64], knots: NDArray[np.float64]) -> NDArray[np.float64]:
    from scipy.interpolate import BSpline  # noqa: PLC0415 (slow to import, and every command reads settings)

    return np.asarray(BSpline.design_matrix(share, knots, SPLINE_DEGREE, extrapolate=True).toarray())


@dataclass(frozen=True, slots=True)
class Form:
    """Which terms a surface has.

    Attributes
    ----------
    shaft_z_m : (low, high)
        Ends of the shaft, metres.
    axis_order : int
        Order of the axis: 1 straight, 2 and 3 bent.
    radius_intervals : int
        Intervals of the spline of the radius; 0 for a polynomial of ``radius_order``.
    radius_order : int
        0 for a cylinder, 1 for a cone; does not count with a spline.
    harmonics : int
        Highest harmonic of the section, 0 for round ones.
    harmonic_order : int
        Order in height of every a_k and b_k.
    free : (int, int) or None
        Highest harmonic and order in height that the data ask for; the ones beyond are held near zero. None where none is
        held.
    """

    shaft_z_m: tuple[float, float]
    axis_order: int
    radius_intervals: int
    radius_order: int = 1
    harmonics: int = 0
    harmonic_order: int = 0
    free: tuple[int, int] | None = None

    @property
    def held(self) -> NDArray[np.bool_]:
        """Which coefficients (size,) of harmonics are held near zero."""
        held = np.zeros(self.size, dtype=np.bool_)
        if self.free is None:
            return held
        highest, order = self.free
        width = self.harmonic_order + 1
        first = 2 * self.n_axis + self.n_radius
        for number, k in enumerate(np.repeat(self.orders, 2)):
            own = held[first + number * width : first + (number + 1) * width]
            own[(order + 1) if k <= highest else 0 :] = True
        return held

    @property
    def half_m(self) -> float:
        """Half the height of the shaft, metres."""
        return 0.5 * (self.shaft_z_m[1] - self.shaft_z_m[0])

    @property
    def middle_m(self) -> float:
        """Height of the middle of the shaft, metres."""
        return 0.5 * (self.shaft_z_m[1] + self.shaft_z_m[0])

    @property
    def n_axis(self) -> int:
        """Coefficients of one component of the axis."""
        return self.axis_order + 1

    @property
    def n_radius(self) -> int:
        """Coefficients of the radius."""
        return self.radius_intervals + SPLINE_DEGREE if self.radius_intervals else self.radius_order + 1

    @property
    def orders(self) -> range:
        """Harmonics that it has."""
        return range(FIRST_HARMONIC, self.harmonics + 1)

    @property
    def size(self) -> int:
        """Number of coefficients: east, north, radius, then a_k and b_k of every harmonic."""
        return 2 * self.n_axis + self.n_radius + 2 * len(self.orders) * (self.harmonic_order + 1)

    @property
    def lean_rows(self) -> list[int]:
        """Places of the slopes of the axis among the coefficients, east and north."""
        return [1, self.n_axis + 1]

    def axis_terms(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Legendre polynomials (n, axis_order + 1) at heights (n,)."""
        return np.asarray(np.polynomial.legendre.legvander(self._share(z_m), self.axis_order))

    def harmonic_terms(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Legendre polynomials (n, harmonic_order + 1) at heights (n,)."""
        return np.asarray(np.polynomial.legendre.legvander(self._share(z_m), self.harmonic_order))

    def radius_terms(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Splines or polynomials (n, n_radius) of the radius at heights (n,)."""
        share = self._share(z_m)
        if not self.radius_intervals:
            return np.asarray(np.polynomial.legendre.legvander(share, self.radius_order))
        inner = np.linspace(-1.0, 1.0, self.radius_intervals + 1)
        step = 2.0 / self.radius_intervals
        below = -1.0 - step * np.arange(SPLINE_DEGREE, 0, -1)
        above = 1.0 + step * np.arange(1, SPLINE_DEGREE + 1)
        knots = np.concatenate([below, inner, above])
        inside = np.clip(share, -1.0, 1.0)
        terms = _splines(inside, knots)
        beyond = np.flatnonzero(share != inside)
        if len(beyond):
            # straight on beyond the ends
            back = inside[beyond] * (1.0 - STRAIGHT_ON)
            slope = (terms[beyond] - _splines(back, knots)) / (inside[beyond] - back)[:, None]
            terms[beyond] += slope * (share[beyond] - inside[beyond])[:, None]
        return terms

    def _share(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray((z_m - self.middle_m) / self.half_m)


def design(form: Form, z_m: NDArray[np.float64], direction: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Derivatives (n, size) of the model distance by the coefficients, at heights (n,) and directions (n,).

    A direction is cos t + i sin t; its length may be below 1, as that of a mean over a cell.
    """
    axis, harmonic = form.axis_terms(z_m), form.harmonic_terms(z_m)
    c, s = direction.real[:, None], direction.imag[:, None]
    columns = [c * axis, s * axis, form.radius_terms(z_m)]
    unit = direction / np.maximum(np.abs(direction), np.finfo(float).tiny)
    for k in form.orders:
        turned = unit**k
        columns += [turned.real[:, None] * harmonic, turned.imag[:, None] * harmonic]
    return np.concatenate(columns, axis=1)


def kept_in(small: Form, large: Form) -> list[int]:
    """Places of the coefficients of a form among those of a larger one that contains it."""
    places = [*range(small.n_axis), *range(large.n_axis, large.n_axis + small.n_axis)]
    radius = 2 * large.n_axis
    places += range(radius, radius + large.n_radius)
    start, width = radius + large.n_radius, large.harmonic_order + 1
    for number in range(2 * len(small.orders)):
        first = start + number * width
        places += range(first, first + small.harmonic_order + 1)
    return places
