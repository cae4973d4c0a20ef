"""Scans of stations in another unit than their positions: the merged cloud then fits no unit as a whole."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.placing import place
from tasks.preprocessing import OTHER_UNITS, ShaftOptions, StructurePrior, isolate_shaft
from tasks.registration import StationPose


def explain_by_unit(
    failure: FitFailure,
    clouds_m: Sequence[NDArray[np.float64]],
    poses: Sequence[StationPose],
    prior: StructurePrior,
    options: ShaftOptions,
) -> FitFailure:
    """Say that the scans are in another unit if the shaft is found once they are scaled; else the failure as it is.

    Parameters
    ----------
    clouds_m : sequence of (n_i, 3) arrays
        Scans in the frames of their scanners, in what was taken for metres.
    poses : sequence of StationPose
        Where the scanners stood; the positions are in metres whatever the scans are in.
    """
    if len(poses) == 1 and not poses[0].position_m.any():
        # a registered cloud lies in the site frame: its search has tried the units itself
        return failure
    for unit in OTHER_UNITS:
        scaled = place([cloud * unit.in_m for cloud in clouds_m], poses)
        if not isinstance(isolate_shaft(scaled.points_m, prior, options), FitFailure):
            return FitFailure(
                f"the scans look like {unit.name}: the shaft is found after scaling them by {unit.in_m:g}, "
                "needed metres; export them in metres"
            )
    return failure
