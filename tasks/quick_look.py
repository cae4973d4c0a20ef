"""A quick look at one scan: how much of the shaft it holds, where, by the stated pose and what is roughly known.

No registration: the shaft is found near where it is expected, as a cone whose foot, lean and radius may be a little off.
That is enough to say which side was seen, and far from enough for a lean.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.design.shaft import CELLS_ROUND, Shaft, whole_surface
from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import mad_sigma, tukey_weights

MOST_POINTS: Final = 300_000
"""As many points of a scan are looked at; they are spread over the whole of it."""

FEWEST_POINTS: Final = 100
"""With fewer near the shaft nothing can be said."""

PRIOR_LEAN: Final = 0.02
PRIOR_RADIUS_M: Final = 0.5
"""By how much the shaft may be off what is roughly known of it, one standard deviation."""

STEPS: Final = 8
LEAST_TOLERANCE_M: Final = 0.15
OF_RADIUS: Final = 0.03
"""A point this near to the cone is on the shaft: noise, ovality and a rough taper, but no ladder and no tree."""


@dataclass(frozen=True, slots=True)
class QuickLook:
    """What a scan holds of the shaft.

    ``counts`` (b, CELLS_ROUND) are its points by band and azimuth of ``tasks.design``, scaled up to the whole scan;
    ``shift_m`` says how far off the expected axis it was found, at mid height.
    """

    counts: NDArray[np.float64]
    n_on_shaft: int
    shift_m: float


def thinned(points_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Every so many of the points (n, 3), and how many points of the scan each stands for."""
    step = max(1, len(points_m) // MOST_POINTS)
    few = points_m[::step]
    return few, len(points_m) / max(len(few), 1)


def quick_look(
    points_m: NDArray[np.float64], scale: float, shaft: Shaft, shift_sigma_m: float
) -> QuickLook | FitFailure:
    """Find the shaft in the points of one scan, and count them by height and azimuth.

    Parameters
    ----------
    points_m : (n, 3) array
        Points in the site frame by the stated pose, metres.
    scale : float
        How many points of the scan each stands for.
    shaft : Shaft
        What is roughly known.
    shift_sigma_m : float
        How far off the shaft may seem to be: heading and position of the station, and the rough foot, metres.
    """
    z = points_m[:, 2]
    offset_m = points_m[:, :2] - np.asarray(shaft.base_xy_m)
    radius_m = shaft.radius_m[0] + shaft.radius_slope * (z - shaft.z_m[0])
    margin_m = 2.5 * shift_sigma_m + PRIOR_RADIUS_M
    near = (z >= shaft.z_m[0]) & (z <= shaft.z_m[1])
    near &= np.abs(np.hypot(*offset_m.T) - radius_m) < margin_m
    if np.count_nonzero(near) < FEWEST_POINTS:
        return FitFailure(
            f"only {np.count_nonzero(near)} points lie near the shaft by the stated position and heading; are they right"
        )
    offset_m, z, radius_m = offset_m[near], z[near], radius_m[near]
    high = (z - np.mean(shaft.z_m)) / (shaft.length_m / 2.0)
    cone = _fit_cone(offset_m, high, radius_m, _prior_sigmas(shaft, shift_sigma_m))
    centred_m = offset_m - cone[:2] - high[:, None] * cone[2:4]
    off_m = np.hypot(*centred_m.T) - radius_m - cone[4]
    on = np.abs(off_m) < LEAST_TOLERANCE_M + OF_RADIUS * radius_m
    return QuickLook(
        counts=scale * _counts(centred_m[on], z[on], shaft),
        n_on_shaft=round(scale * int(np.count_nonzero(on))),
        shift_m=float(np.hypot(*cone[:2])),
    )


def _prior_sigmas(shaft: Shaft, shift_sigma_m: float) -> NDArray[np.float64]:
    lean_m = PRIOR_LEAN * shaft.length_m / 2.0
    return np.array([shift_sigma_m, shift_sigma_m, lean_m, lean_m, PRIOR_RADIUS_M])


def _fit_cone(
    offset_m: NDArray[np.float64],
    high: NDArray[np.float64],
    radius_m: NDArray[np.float64],
    prior_sigma_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Shift (2,), lean over the half length (2,) and radius of a cone, by least squares with Tukey's weights."""
    cone = np.zeros(5)
    for _ in range(STEPS):
        centred_m = offset_m - cone[:2] - high[:, None] * cone[2:4]
        distance_m = np.maximum(np.hypot(*centred_m.T), 1e-9)
        off_m = distance_m - radius_m - cone[4]
        towards = centred_m / distance_m[:, None]
        columns = np.column_stack([-towards, -towards * high[:, None], -np.ones(len(high))])
        sigma_m = max(mad_sigma(off_m), 1e-3)
        weights = tukey_weights(off_m, sigma_m) / sigma_m**2
        normal = (columns * weights[:, None]).T @ columns + np.diag(prior_sigma_m**-2.0)
        right = (columns * weights[:, None]).T @ off_m + cone / prior_sigma_m**2
        cone = cone - np.linalg.solve(normal, right)
    return cone


def _counts(centred_m: NDArray[np.float64], z_m: NDArray[np.float64], shaft: Shaft) -> NDArray[np.float64]:
    bands = len(whole_surface(shaft).z_m)
    band = np.minimum(((z_m - shaft.z_m[0]) / shaft.length_m * bands).astype(np.intp), bands - 1)
    turns = np.arctan2(centred_m[:, 0], centred_m[:, 1]) / (2.0 * np.pi) % 1.0
    cell = np.minimum((turns * CELLS_ROUND).astype(np.intp), CELLS_ROUND - 1)
    counts = np.bincount(band * CELLS_ROUND + cell, minlength=bands * CELLS_ROUND)
    return counts.reshape(bands, CELLS_ROUND).astype(np.float64)
