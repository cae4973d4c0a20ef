"""One adjustment of all stations of an epoch: scans against each other, GNSS, heading and level held."""

from dataclasses import dataclass
from itertools import permutations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.conventions import rotation_site_scanner
from tasks.geometry.rotations import nearest_rotation, rotation_from_vector
from tasks.registration.pairs import PairEquations, pair_equations
from tasks.registration.planar import PlanarCloud
from tasks.registration.station import InstrumentSigmas, StationPose, StationScan

FIRST_GATE_M: Final = 1.2
LAST_GATE_M: Final = 0.06
GATE_SHRINKS: Final = 0.8
STEP_SIGMAS: Final = 0.02
"""Converged when no parameter moves by more than this share of its own standard deviation."""

MAX_ITERATIONS: Final = 40


@dataclass(frozen=True, slots=True)
class Adjusted:
    """Poses, normal matrices (6n, 6n) of scans and of priors, and the last comparison of every pair."""

    poses: tuple[StationPose, ...]
    data_information: NDArray[np.float64]
    prior_information: NDArray[np.float64]
    pairs: dict[tuple[int, int], PairEquations]
    iterations: int
    converged: bool


def stated_pose(scan: StationScan) -> StationPose:
    """The pose that position and heading state, with the scanner's z axis plumb."""
    return StationPose(
        scan.station, rotation_site_scanner(scan.heading_rad), np.asarray(scan.position_m, float)
    )


def adjust(clouds: list[PlanarCloud], scans: list[StationScan], sigmas: InstrumentSigmas) -> Adjusted:
    """Gauss-Newton over all poses, with a gate that shrinks from 1.2 m to 6 cm."""
    stated = [stated_pose(scan) for scan in scans]
    prior = np.diag(np.tile(prior_information(sigmas), len(scans)))
    poses, gate = list(stated), FIRST_GATE_M
    for iteration in range(1, MAX_ITERATIONS + 1):
        pairs = _compare_all(clouds, poses, gate)
        data, right = _assemble(pairs, len(scans))
        right += prior @ _prior_residuals(poses, stated)
        step = np.asarray(np.linalg.solve(data + prior, right), dtype=np.float64)
        poses = [_moved(pose, step[SIX * i : SIX * i + SIX]) for i, pose in enumerate(poses)]
        sigma = np.sqrt(np.diag(np.linalg.inv(data + prior)))
        if gate <= LAST_GATE_M and float(np.max(np.abs(step) / sigma)) < STEP_SIGMAS:
            return Adjusted(tuple(poses), data, prior, pairs, iteration, converged=True)
        gate = max(gate * GATE_SHRINKS, LAST_GATE_M)
    return Adjusted(tuple(poses), data, prior, pairs, MAX_ITERATIONS, converged=False)


def prior_information(sigmas: InstrumentSigmas) -> NDArray[np.float64]:
    """Diagonal (6,) of the information that level, heading and GNSS give of one pose."""
    horizontal, vertical = sigmas.position_m
    level, heading = sigmas.level_rad, sigmas.heading_rad
    return np.asarray(1.0 / np.array([level, level, heading, horizontal, horizontal, vertical]) ** 2)


def rotation_vector_from(pose: StationPose, reference: StationPose) -> NDArray[np.float64]:
    """Small rotation (3,), radians about east, north and up, that takes ``reference`` to ``pose``."""
    delta = pose.rotation @ reference.rotation.T
    sine = 0.5 * np.array([delta[2, 1] - delta[1, 2], delta[0, 2] - delta[2, 0], delta[1, 0] - delta[0, 1]])
    size = float(np.linalg.norm(sine))
    return np.asarray(
        sine if size < 1e-12 else sine * (np.arctan2(size, (np.trace(delta) - 1.0) / 2.0) / size)
    )


def _compare_all(
    clouds: list[PlanarCloud], poses: list[StationPose], gate_m: float
) -> dict[tuple[int, int], PairEquations]:
    return {
        (i, j): pair_equations(clouds[i], poses[i], clouds[j], poses[j], gate_m)
        for i, j in permutations(range(len(clouds)), 2)
    }


def _assemble(
    pairs: dict[tuple[int, int], PairEquations], n_stations: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    matrix, vector = np.zeros((SIX * n_stations, SIX * n_stations)), np.zeros(SIX * n_stations)
    for (i, j), pair in pairs.items():
        rows = np.r_[SIX * i : SIX * i + SIX, SIX * j : SIX * j + SIX]
        matrix[np.ix_(rows, rows)] += pair.matrix
        vector[rows] += pair.vector
    return matrix, vector


def _prior_residuals(poses: list[StationPose], stated: list[StationPose]) -> NDArray[np.float64]:
    """Stated minus present parameters (6n,)."""
    parts = [
        np.r_[-rotation_vector_from(pose, prior), prior.position_m - pose.position_m]
        for pose, prior in zip(poses, stated, strict=True)
    ]
    return np.concatenate(parts)


def _moved(pose: StationPose, step: NDArray[np.float64]) -> StationPose:
    rotation = nearest_rotation(rotation_from_vector(step[:3]) @ pose.rotation)
    return StationPose(pose.station, rotation, pose.position_m + step[3:])
