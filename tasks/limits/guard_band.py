"""Does a deviation keep its limit, given how well it is known."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.limits.table import LimitTable, allowable

GUARD_SIGMAS: Final = 2.0
"""Half-width of the guard band, k = 2: about 95 % for the length of a lean that is well above zero."""

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


def verdict(deviation_m: float, sigma_m: float | None, height_m: float, table: LimitTable | None) -> Verdict:
    """Judge a deviation by a limit with a guard band of two sigmas on either side.

    "pass" if deviation + 2 sigma keeps the limit, "fail" if deviation - 2 sigma is beyond it, "cannot
    tell" between. Without sigma it is always "cannot tell", however far the deviation is from the limit:
    what came without an uncertainty may be wrong by more than any band that one could choose for it.

    Parameters
    ----------
    deviation_m : float
        Deviation at ``height_m``, not negative.
    sigma_m : float or None
        Standard deviation of the deviation, None where it is not known.
    height_m : float
        Height of the deviation above the base, above 0.
    table : LimitTable or None
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
    limit_m = allowable(table, height_m)
    if isinstance(limit_m, FitFailure):
        return Verdict(NO_LIMIT, f"{limit_m.reason} ({table.kind} limit)", None)
    against = f"{1000 * limit_m:.1f} mm at {height_m:g} m ({table.described})"
    if sigma_m is None:
        return Verdict(
            CANNOT_TELL, f"{1000 * deviation_m:.1f} mm of unknown uncertainty against {against}", limit_m
        )
    found = f"{1000 * deviation_m:.1f} ± {1000 * GUARD_SIGMAS * sigma_m:.1f} mm (k=2) against {against}"
    return Verdict(_word(deviation_m, GUARD_SIGMAS * sigma_m, limit_m), found, limit_m)


def _word(deviation_m: float, guard_m: float, limit_m: float) -> str:
    if deviation_m + guard_m <= limit_m:
        return PASS
    return FAIL if deviation_m - guard_m > limit_m else CANNOT_TELL
