"""Forms that an axis may have: functions of the height whose first two are the line that fits best."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

MODELS: Final = {1: "straight", 2: "parabola", 3: "cubic"}
"""Names of the polynomials by their order."""

DEGREE: Final = 3
"""Of the splines: bending without kinks in curvature."""


class Form(Protocol):
    """Functions of the height, the range mapped to x = -1 ... 1.

    The first two are 1 and x, all others are orthogonal to them over the range: so the second coefficient is always the
    slope of the line that fits the curve best in the least-squares sense, uniformly over the height, whatever the
    density of the centres.
    """

    @property
    def model(self) -> str:
        """What the form is called."""
        ...

    @property
    def count(self) -> int:
        """How many functions there are."""
        ...

    def values(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The functions (k, p) at x (k,)."""
        ...

    def slopes(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Their derivatives by x (k, p)."""
        ...


@dataclass(frozen=True, slots=True)
class Polynomial:
    """Legendre polynomials up to an order."""

    order: int

    @property
    def model(self) -> str:
        """Name by the order."""
        return MODELS.get(self.order, f"polynomial of order {self.order}")

    @property
    def count(self) -> int:
        """One more than the order."""
        return self.order + 1

    def values(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Legendre polynomials (k, order + 1)."""
        return np.asarray(np.polynomial.legendre.legvander(x, self.order))

    def slopes(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Their derivatives (k, order + 1)."""
        derivatives = np.polynomial.legendre.legder(np.eye(self.count))
        return np.asarray(np.polynomial.legendre.legvander(x, self.order - 1) @ derivatives)


STRAIGHT: Final = Polynomial(1)


@dataclass(frozen=True, slots=True)
class ClampedSpline:
    """Cubic B-splines over equal spans, clamped at both ends, with that many knots between.

    Written as Legendre polynomials up to the cubic and what of the splines is orthogonal to them, so that a form with
    fewer functions is always the beginning of one with more.
    """

    knots: int

    @property
    def model(self) -> str:
        """Name by the knots."""
        return f"spline of {self.knots + 1} span{'s' if self.knots else ''}"

    @property
    def count(self) -> int:
        """Functions: four and one for every inner knot."""
        return self.knots + DEGREE + 1

    def values(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The functions (k, knots + 4)."""
        return np.asarray(_spline(self.knots)(np.clip(x, -1.0, 1.0)))

    def slopes(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Their derivatives (k, knots + 4)."""
        return np.asarray(_spline(self.knots).derivative()(np.clip(x, -1.0, 1.0)))


@lru_cache
def _spline(inner: int) -> "BSpline":
    """Spline with values in R^p: the functions of ``ClampedSpline`` with that many inner knots."""
    from scipy.interpolate import BSpline  # noqa: PLC0415 (slow to import, and every command reads settings)

    edges = np.linspace(-1.0, 1.0, inner + 2)
    knots = np.concatenate([np.full(DEGREE, -1.0), edges, np.full(DEGREE, 1.0)])
    nodes, shares = np.polynomial.legendre.leggauss(DEGREE + 1)
    half = (edges[1] - edges[0]) / 2
    x = (edges[:-1, None] + half * (nodes + 1.0)).ravel()
    splines = BSpline.design_matrix(x, knots, DEGREE).toarray()
    polynomials = np.polynomial.legendre.legvander(x, DEGREE)
    of_polynomials = np.linalg.lstsq(splines, polynomials, rcond=None)[0]
    # the nodes are those of a quadrature that is exact for products, so orthogonal there is orthogonal over the range
    root = np.sqrt(np.tile(half * shares, inner + 1))[:, None]
    q = np.linalg.qr(root * polynomials)[0]
    rest = root * splines - q @ (q.T @ (root * splines))
    turns = np.linalg.svd(rest, full_matrices=False)[2][:inner].T
    shadow = np.linalg.lstsq(root * polynomials, root * splines @ turns, rcond=None)[0]
    return BSpline(knots, np.hstack([of_polynomials, turns - of_polynomials @ shadow]), DEGREE)
