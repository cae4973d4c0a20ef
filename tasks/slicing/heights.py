"""Mid-heights of the slices of a scheme."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError, ShapeError
from tasks.slicing.scheme import SlicingScheme

ROUNDING_M: Final = 1e-9
"""Slack for heights that are decimal fractions: far below any scanner, far above float64 rounding, metres."""

MOST_SLICES: Final = 1_000_000
"""More slices than this is a slip of the unit, not a wish."""


def slice_heights(scheme: SlicingScheme, shaft_z_m: tuple[float, float]) -> NDArray[np.float64]:
    """Mid-heights of the slices that fit whole into the shaft.

    By interval: the first slice stands on the lower end, the next follow every ``interval_m`` while they fit.
    Ends only: the lowest and the highest slice that fit. A shaft too short for them gives fewer slices, or none.

    Parameters
    ----------
    scheme : SlicingScheme
        Where to cut.
    shaft_z_m : (lo, hi)
        Ends of the shaft in the site frame, metres, lo < hi.

    Returns
    -------
    (m,) array
        Mid-heights, ascending, metres.

    Raises
    ------
    ShapeError
        If ``shaft_z_m`` is not ascending and finite.
    InputError
        If a listed height does not lie in the shaft with its whole slice, or the interval is out of all measure.

    References
    ----------
    Zhou et al. 2025, section 2.2.1 and table 1 (101, 21, 11, 6, 2, 2 slices on 100.01 m).
    """
    low, high = float(shaft_z_m[0]), float(shaft_z_m[1])
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise ShapeError(f"slice_heights needs shaft_z_m (lo, hi) with lo < hi, got ({low:g}, {high:g})")
    first, last = low + scheme.thickness_m / 2, high - scheme.thickness_m / 2
    if scheme.heights_m is not None:
        return _listed(scheme, first, last)
    if last < first - ROUNDING_M:
        return np.empty(0)
    if scheme.interval_m is None:
        return np.array([first, last]) if last > first + ROUNDING_M else np.array([first])
    return _spaced(scheme.name, scheme.interval_m, first, last)


def _listed(scheme: SlicingScheme, first: float, last: float) -> NDArray[np.float64]:
    heights = np.array(scheme.heights_m, dtype=np.float64)
    outside = heights[(heights < first - ROUNDING_M) | (heights > last + ROUNDING_M)]
    if outside.size:
        raise InputError(
            f"scheme {scheme.name!r} has heights_m outside the shaft: {outside.tolist()}; "
            f"slices of {scheme.thickness_m:g} m fit from {first:g} to {last:g} m"
        )
    return heights


def _spaced(name: str, interval_m: float, first: float, last: float) -> NDArray[np.float64]:
    count = np.floor((last - first + ROUNDING_M) / interval_m) + 1
    if count > MOST_SLICES:
        raise InputError(
            f"scheme {name!r} with interval_m = {interval_m:g} needs {count:.0f} slices; at most {MOST_SLICES}"
        )
    return np.asarray(first + interval_m * np.arange(int(count)))
