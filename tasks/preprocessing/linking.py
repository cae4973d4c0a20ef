"""The rough axis and radius that the circles of most height bands agree on."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.geometry.robust import huber_weights
from tasks.preprocessing.kinds import StructureKind
from tasks.preprocessing.prior import StructurePrior

LINK_RADII: Final = 0.3
"""How far, in radii, a band's centre or radius may be off the line of two others: room for bending and bad bands."""

BANDS_NEEDED: Final = 4
SHARE_NEEDED: Final = 0.3
"""Bands that must agree, as a number and as a share of all: less could be chance."""


@dataclass(frozen=True, slots=True)
class BandCircles:
    """All circles of all bands: band index (k,) ascending, height (k,), (k, 3) east, north, radius in metres, score (k,)."""

    band: NDArray[np.int64]
    z_m: NDArray[np.float64]
    parameters_m: NDArray[np.float64]
    scores: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RoughShaft:
    """Polynomials in z, highest power first: (d, 3) for east, north and radius in metres about ``z_mid_m``."""

    coefficients: NDArray[np.float64]
    z_mid_m: float
    n_bands: int

    def at(self, z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """East, north and radius (n, 3) at heights (n,), metres."""
        return np.vander(z_m - self.z_mid_m, len(self.coefficients)) @ self.coefficients


def link_bands(
    circles: BandCircles, prior: StructurePrior, kind: StructureKind, n_bands: int
) -> RoughShaft | FitFailure:
    """Link the circles of the bands into one rough shaft, led by the line that most of them lie on.

    Of two shafts that are as good, the one nearer to the prior's position wins.
    """
    supporters = _best_line(circles, prior, kind)
    agreeing = len(np.unique(circles.band[supporters]))
    needed = max(BANDS_NEEDED, int(np.ceil(SHARE_NEEDED * n_bands)))
    if agreeing < needed:
        return FitFailure(
            f"needed round sections on one line in at least {needed} of {n_bands} height bands, "
            f"found them in {agreeing} within {kind.position_slack_m:g} m of base_xy_m {prior.base_xy_m}"
        )
    return _smooth_through(circles, supporters, float(np.mean(prior.shaft_z_m)), agreeing)


def _best_line(circles: BandCircles, prior: StructurePrior, kind: StructureKind) -> NDArray[np.int64]:
    """Indices of the circles on the best of all lines through two of them; empty if there is no line."""
    first, second = np.triu_indices(len(circles.z_m), k=1)
    apart_m = circles.z_m[second] - circles.z_m[first]
    far_enough = apart_m >= 0.2 * (prior.shaft_z_m[1] - prior.shaft_z_m[0])
    first, second, apart_m = first[far_enough], second[far_enough], apart_m[far_enough]
    slope = (circles.parameters_m[second] - circles.parameters_m[first]) / apart_m[:, None]
    base = circles.parameters_m[first] + slope * (prior.shaft_z_m[0] - circles.z_m[first])[:, None]
    off_base_m = np.hypot(base[:, 0] - prior.base_xy_m[0], base[:, 1] - prior.base_xy_m[1])
    # the slack is a limit, and the line through two noisy centres is off by some of a radius at the foot
    possible = np.hypot(slope[:, 0], slope[:, 1]) <= kind.max_lean + LINK_RADII * base[:, 2] / apart_m
    possible &= off_base_m <= kind.position_slack_m + LINK_RADII * np.abs(base[:, 2])
    if not possible.any():
        return np.empty(0, dtype=np.int64)
    slope, base, off_base_m = slope[possible], base[possible], off_base_m[possible]
    near = _near(circles, slope, base, prior.shaft_z_m[0])
    starts = np.flatnonzero(np.diff(circles.band, prepend=-1))
    votes = np.maximum.reduceat(near * circles.scores, starts, axis=1).sum(axis=1)
    votes *= np.exp(-0.5 * (off_base_m / (2.0 * kind.position_slack_m)) ** 2)
    return np.flatnonzero(near[np.argmax(votes)])


def _near(
    circles: BandCircles, slope: NDArray[np.float64], base: NDArray[np.float64], z0_m: float
) -> NDArray[np.bool_]:
    """Which circles (k,) are near which lines (l, 3), as (l, k)."""
    up_m = circles.z_m - z0_m
    east, north, radius = (
        circles.parameters_m[:, i] - (base[:, i, None] + slope[:, i, None] * up_m) for i in range(3)
    )
    gate_m = LINK_RADII * circles.parameters_m[:, 2]
    return np.asarray((np.hypot(east, north) <= gate_m) & (np.abs(radius) <= gate_m))


def _smooth_through(
    circles: BandCircles, chosen: NDArray[np.int64], z_mid_m: float, n_bands: int
) -> RoughShaft:
    """Put a parabola (a line for few bands) through the chosen circles by Huber's weights."""
    up_m, wanted = circles.z_m[chosen] - z_mid_m, circles.parameters_m[chosen]
    powers = np.vander(up_m, 3 if n_bands >= 2 * BANDS_NEEDED else 2)
    weights = circles.scores[chosen]
    for _ in range(10):
        root = np.sqrt(weights)[:, None]
        coefficients = np.linalg.lstsq(powers * root, wanted * root, rcond=None)[0]
        off_m = np.linalg.norm(wanted - powers @ coefficients, axis=1)
        weights = circles.scores[chosen] * huber_weights(off_m, max(float(np.median(off_m)), 1e-6))
    return RoughShaft(np.asarray(coefficients, dtype=np.float64), z_mid_m, n_bands)
