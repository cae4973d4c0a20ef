"""Whether a difference of several components is more than chance."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

SIGNIFICANT_P: Final = 0.01
"""A change is significant below this probability."""

POWER: Final = 0.8
"""The smallest detectable change is found in this share of cases."""

LEAST_RATIO: Final = 1e-9
"""Of the eigenvalues of a correlation; below it a direction is singular up to rounding and tests nothing."""


@dataclass(frozen=True, slots=True)
class ChangeTest:
    """A difference d (k,) against its covariance: d' C^-1 d is chi-square with k degrees of freedom if nothing changed.

    ``size`` is the length of d, ``sigma`` its standard deviation along d (the largest where d is zero), ``largest`` that in
    the worst direction, ``smallest_detectable`` the length that a 1 % test finds in 80 % of cases there; all in the unit
    of d.
    """

    statistic: float
    freedom: int
    size: float
    sigma: float
    largest: float

    @property
    def p_value(self) -> float:
        """Probability of such a statistic or a larger one by chance."""
        from scipy.special import chdtrc  # noqa: PLC0415 (slow to import)

        return float(chdtrc(self.freedom, self.statistic))

    @property
    def significant(self) -> bool:
        """Whether chance alone would do so in less than 1 of 100 cases."""
        return self.p_value < SIGNIFICANT_P

    @property
    def smallest_detectable(self) -> float:
        """Length of a change that the test finds in 80 % of cases, in the worst direction."""
        return detectable_factor(self.freedom) * self.largest


def chi_square_test(difference: NDArray[np.float64], covariance: NDArray[np.float64]) -> ChangeTest | None:
    """Test a difference (k,) by its covariance (k, k); None where that is singular and so tests nothing.

    Raises
    ------
    ShapeError
        If shapes are wrong or values not finite.
    """
    d, C = np.asarray(difference, dtype=np.float64), np.asarray(covariance, dtype=np.float64)
    if d.ndim != 1 or C.shape != (len(d), len(d)) or not (np.isfinite(d).all() and np.isfinite(C).all()):
        raise ShapeError(
            f"chi_square_test needs a finite difference (k,) and covariance (k, k), got {d.shape} and {C.shape}"
        )
    if not (np.diag(C) > 0.0).all():
        return None
    scale = np.sqrt(np.diag(C))
    correlation = C / np.outer(scale, scale)
    if np.linalg.eigvalsh(correlation)[0] <= LEAST_RATIO:
        return None
    size, largest = float(np.linalg.norm(d)), float(np.sqrt(np.linalg.eigvalsh(C)[-1]))
    unit = d / scale
    return ChangeTest(
        statistic=float(unit @ np.linalg.solve(correlation, unit)),
        freedom=len(d),
        size=size,
        sigma=float(np.sqrt(d @ C @ d)) / size if size > 0.0 else largest,
        largest=largest,
    )


@lru_cache(maxsize=256)
def detectable_factor(freedom: int, significance: float = SIGNIFICANT_P, power: float = POWER) -> float:
    """Root of the noncentrality at which a test of that many degrees of freedom has that power."""
    from scipy.optimize import brentq  # noqa: PLC0415 (slow to import, and every run compares)
    from scipy.special import chdtri  # noqa: PLC0415 (slow to import)
    from scipy.stats import ncx2  # noqa: PLC0415

    critical = float(chdtri(freedom, significance))
    most = 10.0 * (critical + freedom)
    return float(np.sqrt(brentq(lambda n: ncx2.sf(critical, freedom, n) - power, 1e-9, most)))
