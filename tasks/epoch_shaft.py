"""Take the shaft of an epoch out of its placed scans, and check the scanners' levels against it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.level_check import LevelCheck, check_levels
from tasks.placing import PlacedCloud, place
from tasks.preprocessing import Removal, ShaftModel, ShaftOptions, StructurePrior, isolate_shaft
from tasks.registration import Registration
from tasks.scan_units import explain_by_unit


@dataclass(frozen=True, slots=True)
class EpochShaft:
    """Points from the bottom up with their stations, rough model, what was removed, how plumb each station is."""

    cloud: PlacedCloud
    model: ShaftModel
    removed: tuple[Removal, ...]
    levels: tuple[LevelCheck, ...]
    n_points_in: int

    @property
    def shares(self) -> NDArray[np.float64]:
        """Share (n,) of every station in the points."""
        return self.cloud.shares(len(self.levels))


def isolate_epoch(
    scans_m: Sequence[NDArray[np.float64]],
    registration: Registration,
    prior: StructurePrior,
    options: ShaftOptions,
) -> EpochShaft | FitFailure:
    """Place scans (n_i, 3), scanner frames, by their registration and isolate the shaft."""
    placed = place(scans_m, registration.poses)
    shaft = isolate_shaft(placed.points_m, prior, options)
    if isinstance(shaft, FitFailure):
        return explain_by_unit(shaft, scans_m, registration.poses, prior, options)
    # from the bottom up: what is near in height is near in memory, and slices need no sorting
    rising = shaft.keep[np.argsort(placed.points_m[shaft.keep, 2], kind="stable")]
    kept = PlacedCloud(placed.points_m[rising], placed.station_index[rising])
    sigmas = [diagnosis.sigma_level_rad for diagnosis in registration.diagnoses]
    levels = check_levels(kept.points_m, kept.station_index, shaft.model, sigmas)
    return EpochShaft(kept, shaft.model, shaft.removed, levels, len(placed.points_m))
