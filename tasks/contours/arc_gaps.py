"""Which part of a circumference has points, whatever their number."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

SEEN_GAP_DEG: Final = 20.0
"""Neighbouring points further apart than this leave a part of the circumference unseen, degrees."""


@dataclass(frozen=True, slots=True)
class ArcGaps:
    """The widest gap between neighbouring directions, and 360 less all gaps wider than 20, degrees."""

    widest_deg: float
    covered_deg: float


def arc_gaps(xy_m: NDArray[np.float64], center_m: NDArray[np.float64]) -> ArcGaps:
    """Gaps between the directions of points (n, 2) about a centre (2,), n >= 1.

    Sectors of 5 degrees would count a full ring of 60 points as 200 degrees; gaps count it as what it is.
    """
    angle = np.sort(np.degrees(np.arctan2(xy_m[:, 1] - center_m[1], xy_m[:, 0] - center_m[0])))
    gaps = np.diff(angle, append=angle[0] + 360.0)
    unseen = float(gaps[gaps > SEEN_GAP_DEG].sum())
    return ArcGaps(float(gaps.max()), max(360.0 - unseen, 0.0))
