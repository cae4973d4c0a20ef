"""From a placement to its figures: the lean that it leads to, and how far its poses are from the truth."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.registration.known import KnownEpoch, heading_rad
from tasks.conventions import ARCSEC_RAD
from tasks.epoch_shaft import EpochShaft, isolate_epoch
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.methods import method_of
from tasks.preprocessing import ShaftOptions
from tasks.registration import Registration
from tasks.scheme_lean import IsolatedShaft, lean_of_scheme
from tasks.slicing import SCHEMES

SCHEME: Final = "A"
METHOD: Final = "robust"


@dataclass(frozen=True, slots=True)
class PoseErrors:
    """Found minus true.

    ``errors`` (n, 6) are in the order of ``tasks.conventions``. The relative figures are those that a common shift
    and a common turn about up do not explain: RMS over the stations.
    """

    errors: NDArray[np.float64]
    heading_rms_arcsec: float
    heading_relative_arcsec: float
    position_rms_mm: float
    position_relative_mm: float


def shaft_after(epoch: KnownEpoch, registration: Registration) -> EpochShaft | FitFailure:
    """Place the clouds by a registration and isolate the shaft."""
    scans_m = [epoch.station(pose.station).scan.points_m for pose in registration.poses]
    return isolate_epoch(scans_m, registration, epoch.prior, ShaftOptions())


def lean_of(epoch: KnownEpoch, registration: Registration, shaft: EpochShaft) -> Lean | FitFailure:
    """The same slices and fits for every method: scheme A, robust."""
    isolated = IsolatedShaft(shaft.cloud, shaft.model, registration, epoch.prior.shaft_z_m)
    return lean_of_scheme(isolated, SCHEMES[SCHEME], method_of(SCHEMES[SCHEME], METHOD))


def replaced(shaft: EpochShaft, before: Registration, after: Registration) -> EpochShaft:
    """The points of a shaft that one registration found, at the poses of another; both have the same stations."""
    points_m = np.empty_like(shaft.cloud.points_m)
    for i, (old, new) in enumerate(zip(before.poses, after.poses, strict=True)):
        mine = shaft.cloud.station_index == i
        points_m[mine] = new.to_site((shaft.cloud.points_m[mine] - old.position_m) @ old.rotation)
    return replace(shaft, cloud=replace(shaft.cloud, points_m=points_m))


def pose_errors(epoch: KnownEpoch, registration: Registration) -> PoseErrors:
    """Compare every pose that was used with its truth."""
    true = [epoch.station(pose.station).true_pose for pose in registration.poses]
    pairs = list(zip(registration.poses, true, strict=True))
    turns = [Rotation.from_matrix(found.rotation @ truth.rotation.T).as_rotvec() for found, truth in pairs]
    shifts_m = np.array([found.position_m - truth.position_m for found, truth in pairs])
    headings = np.array([_signed(heading_rad(found) - heading_rad(truth)) for found, truth in pairs])
    relative_m = _without_common(shifts_m, np.array([truth.position_m for truth in true]))
    return PoseErrors(
        np.hstack([np.array(turns), shifts_m]),
        _rms(headings) / ARCSEC_RAD,
        _rms(headings - headings.mean()) / ARCSEC_RAD,
        1e3 * _rms(np.linalg.norm(shifts_m, axis=1)),
        1e3 * _rms(np.linalg.norm(relative_m, axis=1)),
    )


def _without_common(shifts_m: NDArray[np.float64], positions_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shifts (n, 3) less the one shift and turn about up that explain most of them."""
    east, north = (positions_m - positions_m.mean(axis=0))[:, :2].T
    centred = shifts_m - shifts_m.mean(axis=0)
    lever = np.column_stack([-north, east, np.zeros(len(east))])
    size = float(np.sum(lever**2))
    return np.asarray(centred - lever * (float(np.sum(lever * centred)) / size)) if size > 0.0 else centred


def _signed(angle_rad: float) -> float:
    return float((angle_rad + np.pi) % (2.0 * np.pi) - np.pi)


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))
