"""Regions and tests of measured vectors with two components, such as a lean: chi-square and F with 2 degrees of freedom."""

from typing import Final

CHI2_95: Final = 5.991464547107979
"""Quantile 0.95 of chi-square with 2 degrees of freedom, -2 log 0.05."""

ELLIPSE_95: Final = 2.4477468306808166
"""Its root: half-axes of the 95 % ellipse in units of the sigmas along them."""

DETECTABLE_FACTOR: Final = 3.7257
"""sqrt(13.8807): the noncentrality that a 1 % test of two degrees of freedom finds in 80 % of cases."""


def f_quantile_2(probability: float, freedom: float) -> float:
    """Quantile of the F distribution with 2 and ``freedom`` degrees of freedom, in closed form."""
    return float(freedom / 2.0 * ((1.0 - probability) ** (-2.0 / freedom) - 1.0))


def small_sample_factor(freedom: int) -> float:
    """Factor for a covariance that rests on a variance estimated with that many degrees of freedom.

    A region of a vector with estimated variance follows F, not chi-square: with 8 degrees of freedom it is half as large
    again. The factor makes the chi-square region of 95 % the right one, so that whoever uses the covariance need not know
    what stands behind it. 0 degrees stand for a variance that is known: factor 1.
    """
    return 1.0 if freedom == 0 else 2.0 * f_quantile_2(0.95, freedom) / CHI2_95
