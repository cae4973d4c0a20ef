"""Take the shaft of an epoch out of its placed scans, and check the scanners' levels against it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.level_check import LevelCheck, check_levels
from tasks.placing import PlacedCloud, place_scans
from tasks.preprocessing import Removal, ShaftModel, ShaftOptions, StructurePrior, isolate_scans
from tasks.registration import Cloud, Registration
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
    scans_m: Sequence[Cloud],
    registration: Registration,
    prior: StructurePrior,
    options: ShaftOptions,
) -> EpochShaft | FitFailure:
    """Place scans (n_i, 3), scanner frames, by their registration and isolate the shaft; scans are read piece by piece."""
    shaft = isolate_scans(place_scans(scans_m, registration.poses), prior, options)
    if isinstance(shaft, FitFailure):
        return explain_by_unit(shaft, scans_m, registration.poses, prior, options)
    sigmas = [diagnosis.sigma_level_rad for diagnosis in registration.diagnoses]
    levels = check_levels(shaft.points_m, shaft.scan_index, shaft.model, sigmas)
    cloud = PlacedCloud(shaft.points_m, shaft.scan_index)
    return EpochShaft(cloud, shaft.model, shaft.removed, levels, shaft.n_points_in)
