"""Normal equations of a surface from its cells, with what holds it where no point does.

Pose errors of the stations move their points together. They are adjusted along, each held at zero by the covariance of
the registration, so that a station counts for what its pose is worth, not for how many points it has.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.surface.cells import Cells
from tasks.surface.form import Form, design

BEND_SD_RADII: Final = 0.02
"""Prior sd of a second difference of the radius between knots, in radii: carries it over heights without points."""

LOBE_SD_RADII: Final = 0.02
"""Prior sd of a coefficient of a harmonic, in radii: what a wall out of round may have."""

OUT_OF_ROUND_RADII: Final = 5e-4
"""The same of a harmonic that was tried and not asked for: 2 mm on a shaft of 4 m, a good wall."""


@dataclass(frozen=True, slots=True, eq=False)
class Normal:
    """Normal equations of a step of the coefficients, the pose errors eliminated.

    Attributes
    ----------
    matrix, right : (p, p) and (p,) arrays
        Points, poses and prior.
    design : (c, p) array
        Derivatives of the residuals of the cells by the coefficients.
    weight : (c,) array
        Information about the mean residual of each cell, 1/m2.
    poses : (c, r) array
        Derivatives by independent unit errors of the poses; r is 0 where no poses are known.
    inner, cross : (r, r) and (p, r) arrays
        Normal matrix of these errors with their prior, and that between coefficients and errors.
    """

    matrix: NDArray[np.float64]
    right: NDArray[np.float64]
    design: NDArray[np.float64]
    weight: NDArray[np.float64]
    poses: NDArray[np.float64]
    inner: NDArray[np.float64]
    cross: NDArray[np.float64]

    def step(self) -> NDArray[np.float64]:
        """Step (p,) of the coefficients, metres."""
        return np.asarray(np.linalg.solve(self.matrix, self.right), dtype=np.float64)

    def covariance(self) -> NDArray[np.float64]:
        """Covariance (p, p) of the coefficients, poses included, square metres."""
        return np.asarray(np.linalg.inv(self.matrix), dtype=np.float64)

    def pull(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """How linear functions (k, p) of the coefficients follow the residuals of the cells: (k, c)."""
        gain = rows @ self.covariance()
        straight = gain @ self.design.T
        by_poses = np.linalg.solve(self.inner, (gain @ self.cross).T).T @ self.poses.T
        return np.asarray((straight - by_poses) * self.weight)

    def without_poses(self, residual_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Residuals (c,) at the minimum less what the pose errors explain of them, metres."""
        errors = np.linalg.solve(self.inner, self.poses.T @ (self.weight * residual_m))
        return np.asarray(residual_m - self.poses @ errors)

    def kept(self, places: list[int]) -> "Normal":
        """The equations of fewer coefficients, the others held at their values."""
        return Normal(
            self.matrix[np.ix_(places, places)],
            self.right[places],
            self.design[:, places],
            self.weight,
            self.poses,
            self.inner,
            self.cross[places],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Weighed:
    """Cells with what is left of their information (c,) (``Blocks.share``) and how poses move them (c, r)."""

    cells: Cells
    share: NDArray[np.float64]
    poses: NDArray[np.float64]

    @property
    def weight(self) -> NDArray[np.float64]:
        """Information about the mean residual of each cell, 1/m2."""
        return np.asarray(self.cells.weight * self.share / self.cells.robust_price)


def normal_of(weighed: Weighed, form: Form, values_m: NDArray[np.float64]) -> Normal:
    """Set up the normal equations of a form with values (p,), which the prior pulls to zero."""
    terms = design(form, weighed.cells.foot_m, weighed.cells.direction)
    return normal_with(weighed, terms, form, values_m)


def normal_with(
    weighed: Weighed, terms: NDArray[np.float64], form: Form, values_m: NDArray[np.float64]
) -> Normal:
    """The same with the derivatives (c, p) of the form, which stay while cells keep their directions and heights."""
    poses, weight = weighed.poses, weighed.weight
    p, r = terms.shape[1], poses.shape[1]
    columns = np.concatenate([terms, poses, weighed.cells.residual_m[:, None]], axis=1)
    columns *= np.sqrt(weight)[:, None]
    # a product of a matrix with itself takes half of the multiplications of others
    products = columns.T @ columns
    cross, inner = products[:p, p : p + r], products[p : p + r, p : p + r] + np.eye(r)
    explained = np.linalg.solve(inner, np.column_stack([cross.T, products[p : p + r, -1]]))
    prior = prior_matrix(form, mean_radius_m(form, values_m))
    matrix = products[:p, :p] + prior - cross @ explained[:, :-1]
    right = products[:p, -1] - prior @ values_m - cross @ explained[:, -1]
    return Normal(
        np.asarray((matrix + matrix.T) / 2.0), np.asarray(right), terms, weight, poses, inner, cross
    )


def prior_matrix(form: Form, radius_m: float) -> NDArray[np.float64]:
    """Information (p, p) of the prior: a radius without kinks, and harmonics that are small; nothing on the axis."""
    matrix = np.zeros((form.size, form.size))
    first = 2 * form.n_axis
    if form.radius_intervals:
        bend = np.diff(np.eye(form.n_radius), 2, axis=0)
        block = slice(first, first + form.n_radius)
        matrix[block, block] = bend.T @ bend / (BEND_SD_RADII * radius_m) ** 2
    rest = np.arange(first + form.n_radius, form.size)
    sd_m = np.where(form.held[rest], OUT_OF_ROUND_RADII, LOBE_SD_RADII) * radius_m
    matrix[rest, rest] = 1.0 / sd_m**2
    return matrix


def mean_radius_m(form: Form, values_m: NDArray[np.float64]) -> float:
    """Mean radius of a form with values (p,), metres."""
    first = 2 * form.n_axis
    if form.radius_intervals:
        return float(values_m[first : first + form.n_radius].mean())
    return float(values_m[first])
