"""Does a deviation keep its limit, given how well it is known."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.limits.table import LimitKind, LimitTable, MissingLimit, allowable

GUARD_SIGMAS: Final = 2.0
"""Half-width of the guard band, k = 2: about 95 % for the length of a lean that is well above zero."""

NEAR_ZERO_SIGMAS: Final = 3.0
"""A length below so many sigmas has no direction: its error has two components, and it comes out too long."""

NEAR_ZERO_GUARD_SIGMAS: Final = 2.75
"""Half-width of the guard band there: a vector of two components is longer than this by as small a chance (2.3 %) as one
component is beyond 2 sigma to one side."""

PASS: Final = "pass"  # noqa: S105  (the word of the contract, no password)
FAIL: Final = "fail"
CANNOT_TELL: Final = "cannot tell"
NO_LIMIT: Final = "no limit"


@dataclass(frozen=True, slots=True)
class Verdict:
    """The three columns of the tilt view: ``allowable_m`` is None exactly where the word is "no limit"."""

    verdict: str
    reason: str
    allowable_m: float | None


def verdict(
    deviation_m: float, sigma_m: float | None, height_m: float, table: LimitTable | MissingLimit | None
) -> Verdict:
    """Judge a deviation by a limit with a guard band of two sigmas on either side.

    "pass" if deviation + 2 sigma keeps the limit, "fail" if deviation - 2 sigma is beyond it, "cannot
    tell" between. Without sigma it is always "cannot tell", however far the deviation is from the limit:
    what came without an uncertainty may be wrong by more than any band that one could choose for it.

    A length has one limit, from above, so each of the two wrong words has one tail: 2.3 % at 2 sigma. Where the deviation
    (for "pass") or the limit (for "fail") is below three sigmas, both components of the lean count and the band is 2.75
    sigmas wide. A limit of kind measurement is kept or not by the sigma alone: it says how well one had to measure.

    Parameters
    ----------
    deviation_m : float
        Deviation at ``height_m``, not negative.
    sigma_m : float or None
        Standard deviation of the deviation, None where it is not known.
    height_m : float
        Height of the deviation above the base, above 0.
    table : LimitTable, MissingLimit or None
        The limit, None where the campaign names none.

    Returns
    -------
    Verdict
        The word, a reason that names the limit and its kind, and the allowable deviation.

    Raises
    ------
    ShapeError
        If a number is negative or not finite.

    References
    ----------
    The guard band follows the idea of JCGM 106 and ISO 14253-1.
    """
    numbers = [deviation_m, 0.0 if sigma_m is None else sigma_m]
    if not np.isfinite(numbers).all() or min(numbers) < 0.0:
        raise ShapeError(
            f"verdict needs a deviation and a sigma that are not negative; got {deviation_m}, {sigma_m}"
        )
    if table is None:
        return Verdict(NO_LIMIT, "the campaign file names no limit", None)
    if isinstance(table, MissingLimit):
        return Verdict(NO_LIMIT, f"{table.name}: {table.reason}", None)
    limit_m = allowable(table, height_m)
    if isinstance(limit_m, FitFailure):
        return Verdict(NO_LIMIT, f"{limit_m.reason} ({table.kind} limit)", None)
    against = f"{1000 * limit_m:.1f} mm at {height_m:g} m ({table.described})"
    if sigma_m is None:
        return Verdict(
            CANNOT_TELL, f"{1000 * deviation_m:.1f} mm of unknown uncertainty against {against}", limit_m
        )
    if table.kind is LimitKind.MEASUREMENT:
        return _of_measurement(table.sigmas * sigma_m, table, limit_m, against)
    guard = _guard_sigmas(min(deviation_m, limit_m), sigma_m)
    found = f"{1000 * deviation_m:.1f} ± {1000 * guard * sigma_m:.1f} mm (k={guard:g}) against {against}"
    return Verdict(_word(deviation_m, sigma_m, limit_m), found, limit_m)


def _of_measurement(measured_m: float, table: LimitTable, limit_m: float, against: str) -> Verdict:
    """Judge how well the deviation is known."""
    what = "sigma" if table.sigmas == 1.0 else f"{table.sigmas:g} sigma"
    word = PASS if measured_m <= limit_m else FAIL
    return Verdict(word, f"{what} of the deviation {1000 * measured_m:.1f} mm against {against}", limit_m)


def _word(deviation_m: float, sigma_m: float, limit_m: float) -> str:
    if deviation_m + _guard_sigmas(deviation_m, sigma_m) * sigma_m <= limit_m:
        return PASS
    return FAIL if deviation_m - _guard_sigmas(limit_m, sigma_m) * sigma_m > limit_m else CANNOT_TELL


def _guard_sigmas(length_m: float, sigma_m: float) -> float:
    return GUARD_SIGMAS if length_m >= NEAR_ZERO_SIGMAS * sigma_m else NEAR_ZERO_GUARD_SIGMAS
