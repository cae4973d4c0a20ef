"""Register the stations of an epoch, or take a cloud that is registered already."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.conventions import azimuth_deg
from tasks.registration.adjustment import (
    Adjusted,
    adjust,
    prior_information,
    rotation_vector_from,
    stated_pose,
)
from tasks.registration.observability import weakest_direction
from tasks.registration.planar import planar_cloud
from tasks.registration.station import (
    InstrumentSigmas,
    PoseDiagnosis,
    Registration,
    StationPose,
    StationScan,
)

SUSPECT_SIGMAS: Final = 4.5
"""A correction beyond this many of its own sigmas makes a station suspect: chance does so in one of 3,000 epochs of 8
stations. Its sigma is that of Baarda's test, sqrt(stated - adjusted variance), because a held parameter hardly gives."""

TESTABLE: Final = 0.01
"""Share of the stated variance that the scans must take away before a correction can be tested."""

MIN_OVERLAP: Final = 0.05


def register_stations(scans: Sequence[StationScan], sigmas: InstrumentSigmas) -> Registration:
    """Place the scans of an epoch by GNSS and heading, then adjust all poses jointly.

    The level of every scanner is kept at its stated sigma, so that the adjustment cannot eat a lean.
    Epochs are never registered on the structure itself.

    Raises
    ------
    ShapeError
        If there is no scan.
    """
    if not scans:
        raise ShapeError("register_stations needs at least one scan; got none")
    clouds = [planar_cloud(scan.points_m) for scan in scans]
    adjusted = adjust(clouds, list(scans), sigmas)
    information = adjusted.data_information + adjusted.prior_information
    covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
    diagnoses = tuple(_diagnose(i, scans, adjusted, covariance, sigmas) for i in range(len(scans)))
    return Registration(adjusted.poses, covariance, diagnoses, adjusted.iterations)


def registered_cloud(station: str, sigmas: InstrumentSigmas) -> Registration:
    """Take a cloud that lies in the site frame already: the pose is exact but for the stated sigmas."""
    covariance = np.diag(1.0 / prior_information(sigmas))
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
        start="registered already",
        correction_m=None,
        normalised=(None,) * SIX,
    )
    return Registration((pose,), covariance, (diagnosis,), iterations=0)


def _diagnose(
    i: int,
    scans: Sequence[StationScan],
    adjusted: Adjusted,
    covariance: NDArray[np.float64],
    sigmas: InstrumentSigmas,
) -> PoseDiagnosis:
    pose, stated = adjusted.poses[i], stated_pose(scans[i])
    turn = rotation_vector_from(pose, stated)
    shift = pose.position_m - stated.position_m
    block = slice(SIX * i, SIX * i + SIX)
    sigma = np.sqrt(np.diag(covariance)[block])
    overlap, rmse = _overlap(i, adjusted)
    normalised = _normalised(np.r_[turn, shift], sigma**2, 1.0 / prior_information(sigmas))
    reasons = _suspicions(normalised, overlap, adjusted.converged)
    forward = pose.rotation @ np.array([0.0, 1.0, 0.0])
    return PoseDiagnosis(
        station=pose.station,
        heading_rad=float(np.radians(azimuth_deg(forward[0], forward[1]))),
        # a positive rotation about up turns counter-clockwise: the azimuth goes down
        heading_correction_rad=-float(turn[2]),
        level_east_rad=float(turn[0]),
        level_north_rad=float(turn[1]),
        overlap=overlap,
        rmse_m=rmse,
        sigma_heading_rad=float(sigma[2]),
        sigma_level_rad=float(np.sqrt(np.mean(sigma[:2] ** 2))),
        sigma_position_m=float(np.sqrt(np.mean(sigma[3:] ** 2))),
        weakest_direction=weakest_direction(adjusted.data_information, adjusted.prior_information, i),
        state="suspect" if reasons else "ok",
        reason="; ".join(reasons) or None,
        start="as stated",
        correction_m=shift,
        normalised=tuple(float(value) for value in normalised),
    )


def _overlap(i: int, adjusted: Adjusted) -> tuple[float | None, float | None]:
    """Largest share of this station's planes that match one other station, and the robust rms of its pairs."""
    mine = [pair for (source, _), pair in adjusted.pairs.items() if source == i and pair.n_queries]
    if not mine:
        return None, None
    sigmas = [(pair.sigma_m, pair.n_matches) for pair in mine if pair.sigma_m is not None]
    total = sum(n for _, n in sigmas)
    rmse = float(np.sqrt(sum(s * s * n for s, n in sigmas) / total)) if total else None
    return max(pair.n_matches / pair.n_queries for pair in mine), rmse


def _normalised(
    correction: NDArray[np.float64], adjusted: NDArray[np.float64], stated: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Corrections (6,) in units of their own sigma; 0 where the scans say too little to test one."""
    taken = stated - adjusted
    testable = taken > TESTABLE * stated
    return np.asarray(np.where(testable, correction / np.sqrt(np.where(testable, taken, 1.0)), 0.0))


def _suspicions(normalised: NDArray[np.float64], overlap: float | None, converged: bool) -> list[str]:
    names = ("level east", "level north", "heading", "east", "north", "up")
    reasons = [
        f"{name} corrected by {abs(value):.1f} sigmas: check what the campaign file states"
        for name, value in zip(names, normalised, strict=True)
        if abs(value) > SUSPECT_SIGMAS
    ]
    if overlap is not None and overlap < MIN_OVERLAP:
        reasons.append(
            f"{100 * overlap:.0f} % of its planes match any other station, needed {100 * MIN_OVERLAP:.0f} %: "
            "check heading_deg and position_m"
        )
    if not converged:
        reasons.append("the joint adjustment of the epoch did not converge")
    return reasons
