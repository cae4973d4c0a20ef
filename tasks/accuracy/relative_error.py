"""Equation 23: the relative error."""

import math

from tasks.geometry.failure import FitFailure


def relative_error_pct(value: float, reference: float) -> float | FitFailure:
    """Relative error of a value against a reference in percent, eq. 23, not negative.

    It says how far two results are apart; it is an accuracy only where the reference is a truth.

    Returns
    -------
    float or FitFailure
        Percent, or a failure where the reference is zero.

    References
    ----------
    Zhou et al. 2025, Buildings 15, 3046, eq. 23.
    """
    if reference == 0.0:
        return FitFailure("eq. 23 needs a reference that is not zero; got 0")
    return 100.0 * abs((value - reference) / reference)


def cut_off(value: float, decimals: int) -> float:
    """Cut a number after some decimals without rounding.

    The relative errors of tilt in table 3 of the paper come out this way only; for comparison with the
    paper, never for results.
    """
    scale = 10.0**decimals
    return math.trunc(value * scale) / scale
