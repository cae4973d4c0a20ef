"""Whether two lean vectors differ."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

SIGNIFICANT_P: Final = 0.01
"""A difference is significant below this probability (the same as in the view ``changes``)."""

LEAST_RATIO: Final = 1e-9
"""Of the eigenvalues of a covariance; below it is singular up to rounding and tests nothing."""


@dataclass(frozen=True, slots=True)
class LeanDifference:
    """A difference of two lean vectors, dimensionless, with what its covariance says of it.

    ``covariance`` (2, 2) is None where one is unknown. ``sigma`` is the standard deviation along the difference, the
    largest where nothing differs; ``largest`` that in the worst direction. They and ``chi2`` are None where the
    covariance is unknown or not positive definite.
    """

    difference: NDArray[np.float64]
    covariance: NDArray[np.float64] | None
    chi2: float | None = None
    sigma: float | None = None
    largest: float | None = None

    @property
    def size(self) -> float:
        """Length of the difference."""
        return math.hypot(*self.difference)

    @property
    def p_value(self) -> float | None:
        """Probability of such a chi2 or a larger one by chance; exact for two degrees of freedom."""
        return None if self.chi2 is None else math.exp(-self.chi2 / 2.0)

    @property
    def significant(self) -> bool | None:
        """Whether chance alone would do so in less than 1 of 100 cases; None where nothing can be told."""
        return None if self.p_value is None else self.p_value < SIGNIFICANT_P

    @property
    def variances(self) -> tuple[float, float, float] | tuple[None, None, None]:
        """Variance east, covariance, variance north."""
        if self.covariance is None:
            return (None, None, None)
        C = self.covariance
        return (float(C[0, 0]), float(C[0, 1]), float(C[1, 1]))


def lean_difference(
    difference: NDArray[np.float64], covariance: NDArray[np.float64] | None
) -> LeanDifference:
    """Test a difference (2,) of lean vectors by its covariance (2, 2): d' C^-1 d, chi-square with 2 degrees of freedom.

    Raises
    ------
    ShapeError
        If shapes are wrong or values not finite.
    """
    d = np.asarray(difference, dtype=np.float64)
    if d.shape != (2,) or not np.isfinite(d).all():
        raise ShapeError(f"lean_difference needs a finite difference (2,); got {difference!r}")
    if covariance is None:
        return LeanDifference(d, None)
    C = np.asarray(covariance, dtype=np.float64)
    if C.shape != (2, 2) or not np.isfinite(C).all():
        raise ShapeError(f"lean_difference needs a finite covariance (2, 2); got {covariance!r}")
    smallest, largest = np.linalg.eigvalsh(C)
    if smallest <= LEAST_RATIO * largest:
        return LeanDifference(d, C)
    size, worst = math.hypot(*d), math.sqrt(largest)
    along = math.sqrt(float(d @ C @ d)) / size if size > 0.0 else worst
    return LeanDifference(d, C, float(d @ np.linalg.solve(C, d)), along, worst)
