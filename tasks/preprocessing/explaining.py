"""What a search for a shaft that failed has most likely met."""

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.preprocessing.kinds import StructureKind
from tasks.preprocessing.prior import StructurePrior
from tasks.preprocessing.units import likely_unit


def explain_failure(
    failure: FitFailure,
    points_m: NDArray[np.float64],
    prior: StructurePrior,
    kind: StructureKind,
) -> FitFailure:
    """Say what points (n, 3), the whole cloud or an even sample of it, have instead of a shaft; else the failure itself."""
    if not len(points_m):
        return FitFailure("needed points, the cloud is empty")
    if np.isnan(points_m[:, 2]).all():
        return FitFailure("needed heights, those of all points are no numbers")
    unit = likely_unit(points_m, prior, kind)
    if unit is not None:
        return FitFailure(
            f"looks like {unit.name}: the shaft is found after scaling by {unit.in_m:g}, needed metres; "
            "export it in metres"
        )
    z_m, (low_m, high_m) = points_m[:, 2], prior.shaft_z_m
    if not ((z_m >= low_m) & (z_m <= high_m)).any():
        return FitFailure(
            f"no points in the height range {prior.shaft_z_m} m; the {len(z_m)} points that were looked at reach "
            f"from {np.nanmin(z_m):.2f} to {np.nanmax(z_m):.2f} m"
        )
    return failure
