"""Register the stations of an epoch, or take a cloud that is registered already."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from storage.records import REGISTERED
from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.geometry.failure import FitFailure
from tasks.registration.adjustment import Adjusted, Network
from tasks.registration.diagnosis import MIN_OVERLAP, best_overlap, diagnose_stations, is_tied
from tasks.registration.pair_report import diagnose_pairs
from tasks.registration.planar import ScanPlanes, scan_planes
from tasks.registration.shaft_factor import shaft_points
from tasks.registration.stable import StableSurroundings, stable_planes
from tasks.registration.stable_check import stable_warnings
from tasks.registration.start import Start, find_starts, without_empty
from tasks.registration.stated import stated_information, stated_pose
from tasks.registration.statement_test import Settled, settle
from tasks.registration.station import (
    InstrumentSigmas,
    PoseDiagnosis,
    RefusedStation,
    Registration,
    ShaftHint,
    StationPose,
    StationScan,
)

LEAST_TO_LEAVE_OUT: Final = 3
"""Of two stations nobody can say which one does not belong."""


def register_stations(
    scans: Sequence[StationScan],
    sigmas: InstrumentSigmas,
    hint: ShaftHint | None = None,
    stable: StableSurroundings | None = None,
) -> Registration | FitFailure:
    """Place the scans of an epoch by GNSS and heading, then adjust all poses jointly.

    The level of every scanner is kept at its stated sigma, so that the adjustment cannot eat a lean.
    Epochs are never registered on the structure itself; ``stable`` holds the frame of the reference epoch by
    surroundings that do not move. A station that cannot be placed is left out and named.

    Parameters
    ----------
    scans : sequence of StationScan
        Scans in the frames of their scanners, with the poses that the crew states.
    sigmas : InstrumentSigmas
        What the stated poses are worth.
    hint : ShaftHint, optional
        What is roughly known of the structure: headings and positions that are missing or wrong are found by it.
    stable : StableSurroundings, optional
        Surroundings of the reference epoch.

    Returns
    -------
    Registration or FitFailure
        The failure says why no station could be placed.

    Raises
    ------
    ShapeError
        If there is no scan.
    """
    if not scans:
        raise ShapeError("register_stations needs at least one scan; got none")
    planes = scan_planes([scan.points_m for scan in scans])
    starts = find_starts(scans, planes, sigmas, hint)
    if len(scans) > 1:
        starts = without_empty(starts, planes)
    placed = [
        _Placed(*pair) for pair in zip(starts.stations, planes, strict=True) if pair[0].pose is not None
    ]
    refused = [
        RefusedStation(start.scan.station, start.suspicion or "cannot be placed")
        for start in starts.stations
        if start.pose is None
    ]
    if not placed:
        return FitFailure("; ".join(f"station {one.station}: {one.reason}" for one in refused))
    epoch = _Epoch(sigmas, starts.seen, stable)
    settled, placed, loose = _settle_without_loose(placed, epoch)
    frame = _frame_covariance(settled.adjusted, stable)
    covariance = _own_covariance(settled.adjusted) + (0.0 if frame is None else frame)
    stated = {scan.station: scan for scan in scans}
    diagnoses = diagnose_stations(
        settled, covariance, [one.start for one in placed], [stated[one.start.scan.station] for one in placed]
    )
    return Registration(
        poses=settled.adjusted.poses,
        covariance=covariance,
        diagnoses=diagnoses,
        iterations=settled.adjusted.iterations,
        pairs=diagnose_pairs(settled.adjusted, starts.seen),
        refused=(*refused, *loose),
        warnings=() if stable is None else tuple(stable_warnings(settled, stable)),
        frame_covariance=frame,
    )


def registered_cloud(station: str, sigmas: InstrumentSigmas) -> Registration:
    """Take a cloud that lies in the site frame already: the pose is exact but for the stated sigmas."""
    covariance = np.diag(1.0 / stated_information(sigmas))
    pose = StationPose(station, np.eye(3), np.zeros(3))
    diagnosis = PoseDiagnosis(
        station=station,
        heading_rad=0.0,
        heading_correction_rad=0.0,
        level_east_rad=0.0,
        level_north_rad=0.0,
        overlap=None,
        rmse_m=None,
        sigma_heading_rad=sigmas.heading_rad,
        sigma_level_rad=sigmas.level_rad,
        sigma_position_m=float(np.sqrt(np.mean(np.diag(covariance)[3:]))),
        weakest_direction=None,
        state="ok",
        reason=None,
        start=REGISTERED,
        correction_m=None,
        normalised=(None,) * SIX,
    )
    return Registration((pose,), covariance, (diagnosis,), iterations=0)


@dataclass(frozen=True, slots=True)
class _Placed:
    start: Start
    planes: ScanPlanes


@dataclass(frozen=True, slots=True)
class _Epoch:
    """What all stations of an epoch share."""

    sigmas: InstrumentSigmas
    seen: ShaftHint | None
    stable: StableSurroundings | None


def _settle_without_loose(
    placed: list[_Placed], epoch: _Epoch
) -> tuple[Settled, list[_Placed], list[RefusedStation]]:
    """Adjust; leave out the station that nothing ties to the others, and adjust again, while three or more are there."""
    loose: list[RefusedStation] = []
    while True:
        settled = settle(_network(placed, epoch), [_pose(one.start) for one in placed])
        untied = [i for i in range(len(placed)) if not is_tied(i, settled.adjusted)]
        if len(placed) < LEAST_TO_LEAVE_OUT or not untied:
            return settled, placed, loose
        shares = [best_overlap(i, settled.adjusted) or 0.0 for i in untied]
        worst = untied[int(np.argmin(shares))]
        reason = (
            f"{100 * min(shares):.0f} % of its planes match any other station, needed {100 * MIN_OVERLAP:.0f} %; "
            "left out; check scan, heading_deg and position_m"
        )
        loose.append(RefusedStation(placed[worst].start.scan.station, reason))
        placed = [one for k, one in enumerate(placed) if k != worst]


def _network(placed: list[_Placed], epoch: _Epoch) -> Network:
    planes = tuple(one.planes for one in placed)
    poses = [_pose(one.start) for one in placed]
    shaft = None
    if epoch.seen is not None and epoch.seen.ties == "common shaft":
        shaft = shaft_points(planes, poses, epoch.seen)
    return Network(
        planes,
        tuple(stated_pose(one.start.scan, _pose(one.start), epoch.sigmas) for one in placed),
        None if epoch.stable is None else stable_planes(epoch.stable),
        shaft,
    )


def _pose(start: Start) -> StationPose:
    if start.pose is None:
        raise ShapeError(f"station {start.scan.station} has no pose to start from")
    return start.pose


def _own_covariance(adjusted: Adjusted) -> NDArray[np.float64]:
    """Covariance (6n, 6n) of the poses from scans and stated sigmas, as if stable surroundings were where they are."""
    return np.asarray(np.linalg.inv(adjusted.data_information + adjusted.prior_information))


def _frame_covariance(adjusted: Adjusted, stable: StableSurroundings | None) -> NDArray[np.float64] | None:
    """What comes on top: the frame of the reference epoch, which stable surroundings hold; None without them."""
    if stable is None:
        return None
    by_frame = _own_covariance(adjusted) @ adjusted.by_frame
    return np.asarray(by_frame @ stable.covariance @ by_frame.T)
