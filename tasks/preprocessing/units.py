"""Clouds that are not in metres."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.preprocessing.finding import is_there
from tasks.preprocessing.kinds import StructureKind
from tasks.preprocessing.prior import StructurePrior
from tasks.preprocessing.search import reach_m


@dataclass(frozen=True, slots=True)
class LengthUnit:
    """A unit of length and its size in metres."""

    name: str
    in_m: float


OTHER_UNITS: Final = (LengthUnit("feet", 0.3048), LengthUnit("millimetres", 0.001))


def likely_unit(points: NDArray[np.float64], prior: StructurePrior, kind: StructureKind) -> LengthUnit | None:
    """Return the unit in which the coordinates (n, 3) hold the shaft of the prior, if there is one."""
    for unit in OTHER_UNITS:
        near_m = _near(points * unit.in_m, prior, kind)
        if is_there(near_m, prior, kind):
            return unit
    return None


def _near(points_m: NDArray[np.float64], prior: StructurePrior, kind: StructureKind) -> NDArray[np.float64]:
    z_m = points_m[:, 2]
    off_m = np.hypot(points_m[:, 0] - prior.base_xy_m[0], points_m[:, 1] - prior.base_xy_m[1])
    return points_m[
        (z_m >= prior.shaft_z_m[0]) & (z_m <= prior.shaft_z_m[1]) & (off_m <= reach_m(prior, kind))
    ]
