"""How thick a slice may be before the shaft within it is no longer straight."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError

SHARE: Final = 0.25
"""Part of the wanted sigma that a bent slice may shift a centre by: 3 % more of it, added in squares."""


@dataclass(frozen=True, slots=True, eq=False)
class ThicknessLimit:
    """Greatest thickness of slices, by height.

    Attributes
    ----------
    knots_z_m : (k,) array
        Heights between which the limits hold, ascending, metres; the first and the last go on beyond them.
    most_m : (k - 1,) array
        Greatest thickness between them, metres, infinite where nothing bends.
    """

    knots_z_m: NDArray[np.float64]
    most_m: NDArray[np.float64]

    def __post_init__(self) -> None:
        if self.most_m.ndim != 1 or self.knots_z_m.shape != (len(self.most_m) + 1,) or not self.most_m.size:
            raise ShapeError(
                "ThicknessLimit needs heights (k,) and k - 1 thicknesses, k >= 2; "
                f"got {self.knots_z_m.shape} and {self.most_m.shape}"
            )

    def at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Greatest thickness (...) at heights (...), metres."""
        interval = np.searchsorted(self.knots_z_m, z_m, side="right") - 1
        return np.asarray(self.most_m[np.clip(interval, 0, len(self.most_m) - 1)])


def linear_limit(
    knots_z_m: NDArray[np.float64], form_m: NDArray[np.float64], sigma_center_m: float
) -> ThicknessLimit:
    """Find how thick slices may be so that straightening them to first order shifts no centre by much.

    A slice is straightened by one lean of the whole axis and by the taper at its height. What that leaves shifts a
    centre by

    - d h / 4, where the axis leans by d other than the whole, and all points lie in one half of the slice;
    - c h^2 / 24, where the axis has the curvature c, and the points are spread evenly: the mean of c z^2 / 2.

    Each is kept below ``SHARE`` of the wanted sigma: h <= 4 e / d and h <= sqrt(24 e / c) with e = SHARE sigma. A
    curvature of the radius is held to the same: it shifts a centre only where sides are seen at different heights.

    Parameters
    ----------
    knots_z_m : (k,) array
        Heights, ascending, metres, k >= 2.
    form_m : (3, k) array
        East and north of the axis off its straight line, and the radius, at these heights; metres.
    sigma_center_m : float
        Wanted standard deviation of a centre, metres.
    """
    spacing_m = np.diff(knots_z_m)
    slopes = np.diff(form_m, axis=1) / spacing_m
    lean_off = np.hypot(slopes[0], slopes[1])
    turns = np.abs(np.diff(slopes, axis=1))
    curvature_at_knots = (
        np.maximum(np.hypot(turns[0], turns[1]), turns[2]) * 2.0 / (spacing_m[1:] + spacing_m[:-1])
    )
    # an interval is as bent as the more bent of its two ends
    padded = np.concatenate([[0.0], curvature_at_knots, [0.0]])
    curvature = np.maximum(padded[:-1], padded[1:])
    allowed_m = SHARE * sigma_center_m
    with np.errstate(divide="ignore"):
        most_m = np.minimum(4.0 * allowed_m / lean_off, np.sqrt(24.0 * allowed_m / curvature))
    return ThicknessLimit(knots_z_m, most_m)
