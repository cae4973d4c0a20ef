"""What the points of a slice say about its centre, before anything is fitted."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

LEAST_POINTS: Final = 30
"""Fewer points do not tell their own scatter to better than 13 %, so no sigma of a centre either."""

RESOLVED: Final = 1e-9
"""Smaller eigenvalue, a point, below which an arc fixes no centre: one of 2 degrees has 2e-9, rounding 1e-13."""

TERMS: Final = 6
"""Terms of a symmetric 3 x 3 matrix: cos cos, cos sin, sin sin, cos, sin, 1."""


@dataclass(frozen=True, slots=True, eq=False)
class RingPoints:
    """The points of a shaft as a circle sees them.

    Attributes
    ----------
    z_m : (n,) array
        Heights, site frame, metres.
    azimuth_rad : (n,) array
        Direction of each about the rough axis, in any sense and from any zero, radians.
    sigma_m : (n,) array
        Standard deviation of each across the surface, metres.
    weights : (n,) array or None
        Weights of the fit that follows; None for a fit that takes all points alike.
    """

    z_m: NDArray[np.float64]
    azimuth_rad: NDArray[np.float64]
    sigma_m: NDArray[np.float64]
    weights: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        arrays = (self.z_m, self.azimuth_rad, self.sigma_m, *([] if self.weights is None else [self.weights]))
        if {array.shape for array in arrays} != {(self.z_m.size,)}:
            raise ShapeError(
                f"RingPoints needs arrays (n,) of one length, got {[array.shape for array in arrays]}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class CenterSums:
    """Sums over all points below the edge of each of L layers: (L + 1, 2 * TERMS + 1).

    Of w u u^T, of w^2 sigma^2 u u^T, u = (cos, sin, 1), and the number of points.
    """

    below: NDArray[np.float64]

    def between(self, begins: NDArray[np.intp], ends: NDArray[np.intp]) -> NDArray[np.float64]:
        """Sums (m, 2 * TERMS + 1) over the points of layers ``begins`` up to, not with, ``ends``."""
        return np.asarray(self.below[ends] - self.below[begins])


def sum_layers(chunks: Iterable[RingPoints], grid_m: NDArray[np.float64]) -> CenterSums:
    """Sum what points say about a centre, layer by layer between the rising, even heights ``grid_m`` (L + 1,).

    The points may come in chunks, each of which is looked at once.
    """
    from tasks.slicing.layer_kernel import add_to_layers  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

    n_layers = len(grid_m) - 1
    sums = np.zeros((n_layers, 2 * TERMS + 1))
    layers_per_m = float(n_layers / (grid_m[-1] - grid_m[0]))
    for points in chunks:
        weights = np.empty(0) if points.weights is None else points.weights
        add_to_layers(
            points.z_m, points.azimuth_rad, points.sigma_m, weights, float(grid_m[0]), layers_per_m, sums
        )
    below = np.zeros((n_layers + 1, 2 * TERMS + 1))
    np.cumsum(sums, axis=0, out=below[1:])
    return CenterSums(below)


def center_variances(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """Variance (m,) of the less certain component of the centre of a circle, radius free, square metres.

    With N = sum w u u^T and M = sum w^2 sigma^2 u u^T the covariance of the weighted fit is N^-1 M N^-1; for the weights
    1 / sigma^2 it is the bound N^-1. Infinite where fewer than ``LEAST_POINTS`` points or their arc fix no centre.

    Parameters
    ----------
    sums : (m, 2 * TERMS + 1) array
        As ``CenterSums.between`` gives them.

    References
    ----------
    Chernov 2010, Circular and Linear Regression, chapter 7 (bound of a circle's centre).
    """
    cc, cs, ss, c, s, w = sums[:, :TERMS].T
    v_cc, v_cs, v_ss, v_c, v_s, v = sums[:, TERMS : 2 * TERMS].T
    enough = (sums[:, -1] >= LEAST_POINTS) & (w > 0.0)
    # the radius taken out: what is left of directions are their differences from the mean direction
    w = np.where(enough, w, 1.0)
    mean_c, mean_s = c / w, s / w
    n = _Symmetric(cc - c * mean_c, cs - c * mean_s, ss - s * mean_s)
    m = _Symmetric(
        v_cc - 2.0 * mean_c * v_c + mean_c**2 * v,
        v_cs - mean_c * v_s - mean_s * v_c + mean_c * mean_s * v,
        v_ss - 2.0 * mean_s * v_s + mean_s**2 * v,
    )
    resolved = enough & (n.trace - n.largest() > RESOLVED * w)
    largest = np.full(len(sums), np.inf)
    largest[resolved] = n.only(resolved).inverse().around(m.only(resolved)).largest()
    return largest


@dataclass(frozen=True, slots=True, eq=False)
class _Symmetric:
    """Symmetric 2 x 2 matrices, many at once: [[a, b], [b, d]]."""

    a: NDArray[np.float64]
    b: NDArray[np.float64]
    d: NDArray[np.float64]

    @property
    def determinant(self) -> NDArray[np.float64]:
        return np.asarray(self.a * self.d - self.b**2)

    @property
    def trace(self) -> NDArray[np.float64]:
        return np.asarray(self.a + self.d)

    def only(self, which: NDArray[np.bool_]) -> "_Symmetric":
        return _Symmetric(self.a[which], self.b[which], self.d[which])

    def inverse(self) -> "_Symmetric":
        return _Symmetric(self.d / self.determinant, -self.b / self.determinant, self.a / self.determinant)

    def around(self, inner: "_Symmetric") -> "_Symmetric":
        """Self times inner times self."""
        left_a, left_b = self.a * inner.a + self.b * inner.b, self.a * inner.b + self.b * inner.d
        left_c, left_d = self.b * inner.a + self.d * inner.b, self.b * inner.b + self.d * inner.d
        return _Symmetric(
            left_a * self.a + left_b * self.b,
            left_a * self.b + left_b * self.d,
            left_c * self.b + left_d * self.d,
        )

    def largest(self) -> NDArray[np.float64]:
        """Larger eigenvalue."""
        return np.asarray(self.trace / 2 + np.hypot((self.a - self.d) / 2, self.b))
