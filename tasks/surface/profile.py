"""A surface with its coefficients: where the axis is, how far the skin is from it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.surface.form import Form

TABLE_ROWS: Final = 2000
"""Heights at which a surface is tabulated: linear between them, a spline of 2.5 m is good to a micrometre."""


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """A form and its coefficients (size,), metres; east and north of the axis count from ``origin_m`` (2,)."""

    form: Form
    values_m: NDArray[np.float64]
    origin_m: NDArray[np.float64]

    @property
    def lean(self) -> NDArray[np.float64]:
        """Lean vector (2,) of the line that fits the axis best, uniformly over the shaft."""
        return np.asarray(self.values_m[self.form.lean_rows] / self.form.half_m)

    def axis_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Axis (n, 2) at heights (n,), about the origin, metres."""
        n = self.form.n_axis
        return np.asarray(self.form.axis_terms(z_m) @ self.values_m[: 2 * n].reshape(2, n).T)

    def straight_axis_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Line (n, 2) that fits the axis best, at heights (n,), about the origin, metres."""
        n = self.form.n_axis
        middle = self.values_m[[0, n]]
        return np.asarray(middle + np.outer(z_m - self.form.middle_m, self.lean))

    def slope_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Slope (n, 2) of the axis at heights (n,)."""
        n = self.form.n_axis
        share = (z_m - self.form.middle_m) / self.form.half_m
        both = self.values_m[: 2 * n].reshape(2, n).T
        derived = np.polynomial.legendre.legder(both, axis=0) / self.form.half_m
        return np.asarray(np.polynomial.legendre.legval(share, derived).T)

    def radius_at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean radius (n,) at heights (n,), metres."""
        first = 2 * self.form.n_axis
        return np.asarray(self.form.radius_terms(z_m) @ self.values_m[first : first + self.form.n_radius])

    def harmonics_at(self, z_m: NDArray[np.float64]) -> NDArray[np.complex128]:
        """a_k - i b_k at heights (n,): (n, number of harmonics), metres; times (cos t + i sin t)^k its real part counts."""
        first = 2 * self.form.n_axis + self.form.n_radius
        width = self.form.harmonic_order + 1
        pairs = self.values_m[first:].reshape(len(self.form.orders), 2, width)
        terms = self.form.harmonic_terms(z_m)
        return np.asarray(terms @ pairs[:, 0].T - 1j * (terms @ pairs[:, 1].T))

    def moved(self, step_m: NDArray[np.float64]) -> "Profile":
        """The surface after a step (size,) of its coefficients."""
        return Profile(self.form, self.values_m + step_m, self.origin_m)


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Points as a surface sees them.

    ``residual_m`` (n,) is their distance from the axis less that of the skin, ``direction`` (n,) cos t + i sin t, ``foot_m``
    (n,) the height of the axis from which it is counted: their own, unless distances are taken across the axis.
    """

    residual_m: NDArray[np.float64]
    direction: NDArray[np.complex128]
    foot_m: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ProfileTable:
    """A surface tabulated over the height, for many points: columns east, north, radius, slopes, harmonics."""

    low_m: float
    step_m: float
    rows: NDArray[np.float64]
    harmonics: NDArray[np.complex128]
    origin_m: NDArray[np.float64]
    across: bool
    """Distances are taken across the axis, not in the horizontal."""

    def look_at(self, points_m: NDArray[np.float64]) -> Look:
        """Look at points (n, 3) of the site frame."""
        away = points_m[:, :2] - self.origin_m
        place, share = self._place(points_m[:, 2])
        at = self.rows[place] + share[:, None] * (self.rows[place + 1] - self.rows[place])
        de, dn = away[:, 0] - at[:, 0], away[:, 1] - at[:, 1]
        if self.across:
            return self._look_across(points_m[:, 2], at, de, dn)
        distance = np.maximum(np.sqrt(de * de + dn * dn), np.finfo(float).tiny)
        direction = np.asarray((de + 1j * dn) / distance, dtype=np.complex128)
        return Look(distance - at[:, 2] - self._form(place, share, direction), direction, points_m[:, 2])

    def _look_across(
        self,
        z_m: NDArray[np.float64],
        at: NDArray[np.float64],
        de: NDArray[np.float64],
        dn: NDArray[np.float64],
    ) -> Look:
        """Distances from the tangent of the axis; the radius is that where their foot lies."""
        slope_e, slope_n = at[:, 3], at[:, 4]
        length = 1.0 + slope_e**2 + slope_n**2
        along = de * slope_e + dn * slope_n
        distance = np.sqrt(np.maximum(de * de + dn * dn - along**2 / length, np.finfo(float).tiny))
        foot_m = z_m + along / length
        foot, share = self._place(foot_m)
        radius = self.rows[foot, 2] + share * (self.rows[foot + 1, 2] - self.rows[foot, 2])
        # what is left of the horizontal after the part along the axis
        left = (de - along * slope_e / length) + 1j * (dn - along * slope_n / length)
        direction = np.asarray(left / np.maximum(np.abs(left), np.finfo(float).tiny), dtype=np.complex128)
        return Look(distance - radius - self._form(foot, share, direction), direction, foot_m)

    def _place(self, z_m: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        place = (z_m - self.low_m) / self.step_m
        row = np.clip(place.astype(np.intp), 0, len(self.rows) - 2)
        return row, place - row

    def _form(
        self, place: NDArray[np.intp], share: NDArray[np.float64], direction: NDArray[np.complex128]
    ) -> NDArray[np.float64]:
        """What the sections are off the circle at points (n,), metres."""
        form = np.zeros(len(place))
        turned = direction
        for column in self.harmonics.T:
            turned = turned * direction
            at = column[place] + share * (column[place + 1] - column[place])
            form += at.real * turned.real - at.imag * turned.imag
        return form


def tabulate(profile: Profile, *, across: bool) -> ProfileTable:
    """Tabulate a surface; ``across`` for sections that are round across the axis instead of in the horizontal."""
    low, high = profile.form.shaft_z_m
    z = np.linspace(low, high, TABLE_ROWS)
    rows = np.column_stack([profile.axis_at(z), profile.radius_at(z), profile.slope_at(z)])
    return ProfileTable(
        low, float(z[1] - z[0]), rows, profile.harmonics_at(z), profile.origin_m, across=across
    )
