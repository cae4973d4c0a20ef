"""Scans of stations in another unit than their positions: the merged cloud then fits no unit as a whole."""

from collections.abc import Sequence
from typing import Final

from tasks.geometry.failure import FitFailure
from tasks.placing import place
from tasks.preprocessing import OTHER_UNITS, ShaftOptions, StructurePrior, isolate_shaft
from tasks.registration import Cloud, StationPose, sampled

LOOKED_AT: Final = 1 << 21
"""Points, of all scans together, among which the shaft is looked for in other units."""


def explain_by_unit(
    failure: FitFailure,
    clouds_m: Sequence[Cloud],
    poses: Sequence[StationPose],
    prior: StructurePrior,
    options: ShaftOptions,
) -> FitFailure:
    """Say that the scans are in another unit if the shaft is found once they are scaled; else the failure as it is.

    Parameters
    ----------
    clouds_m : sequence of (n_i, 3) arrays or clouds
        Scans in the frames of their scanners, in what was taken for metres.
    poses : sequence of StationPose
        Where the scanners stood; the positions are in metres whatever the scans are in.
    """
    if len(poses) == 1 and not poses[0].position_m.any():
        # a registered cloud lies in the site frame: its search has tried the units itself
        return failure
    samples = [sampled(cloud, max(1, LOOKED_AT // len(clouds_m))) for cloud in clouds_m]
    for unit in OTHER_UNITS:
        scaled = place([sample * unit.in_m for sample in samples], poses)
        if not isinstance(isolate_shaft(scaled.points_m, prior, options), FitFailure):
            return FitFailure(
                f"the scans look like {unit.name}: the shaft is found after scaling them by {unit.in_m:g}, "
                "needed metres; export them in metres"
            )
    return failure
