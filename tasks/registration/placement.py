"""Place a station of which no pose is known, by what it and the well-placed stations see around the structure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import PARAMETERS_PER_STATION as SIX
from tasks.geometry.rotations import nearest_rotation, rotation_from_vector
from tasks.registration.pairs import Matches, match_pair, pair_equations
from tasks.registration.planar import ScanPlanes, chosen
from tasks.registration.station import StationPose

GATES_M: Final = tuple(3.0 * 0.7**k for k in range(12))
"""From a direction that is right to 0.2 degrees at 300 m down to 6 cm."""

TETHER: Final = np.array([1e12, 1e12, 1.0, 1e-2, 1e-2, 1e-2])
"""Information that keeps a step finite; the level is held."""

BESIDE_SHAFT_M: Final = 4.0


@dataclass(frozen=True, slots=True)
class Placement:
    """A pose, and how many planes beside the structure lie in those of other stations there: walls, and ground."""

    pose: StationPose
    n_walls: int
    n_ground: int


def without_structure(planes: ScanPlanes, shaft_m: NDArray[np.float64] | None, radius_m: float) -> ScanPlanes:
    """Planes beside the structure that stands at ``shaft_m`` (2,) of the scanner frame; all where it is not seen."""
    if shaft_m is None:
        return planes
    away = np.hypot(*(planes.fine.points_m[:, :2] - shaft_m).T)
    return ScanPlanes(chosen(planes.fine, away > radius_m + BESIDE_SHAFT_M), planes.coarse)


def settle_alone(
    planes: ScanPlanes, start: StationPose, others: Sequence[ScanPlanes], poses: Sequence[StationPose]
) -> Placement:
    """Fit one scan to others that stand fast; its level is held."""
    pose = start
    for gate_m in GATES_M:
        matrix, vector = np.diag(TETHER), np.zeros(SIX)
        for found, other_pose in _matches(planes, pose, others, poses, gate_m):
            equations = pair_equations(found, pose, other_pose)
            matrix += equations.matrix[:SIX, :SIX]
            vector += equations.vector[:SIX]
        step = np.asarray(np.linalg.solve(matrix, vector), dtype=np.float64)
        rotation = nearest_rotation(rotation_from_vector(step[:3]) @ pose.rotation)
        pose = StationPose(pose.station, rotation, pose.position_m + step[3:])
    counts = [0, 0]
    for k, (found, _) in enumerate(_matches(planes, pose, others, poses, GATES_M[-1])):
        counts[k % 2] += len(found.residuals_m)
    return Placement(pose, counts[0], counts[1])


def _matches(
    planes: ScanPlanes,
    pose: StationPose,
    others: Sequence[ScanPlanes],
    poses: Sequence[StationPose],
    gate_m: float,
) -> list[tuple[Matches, StationPose]]:
    return [
        (match_pair(source, pose, target, other_pose, gate_m), other_pose)
        for other, other_pose in zip(others, poses, strict=True)
        for source, target in zip(planes.layers, other.layers, strict=True)
    ]
