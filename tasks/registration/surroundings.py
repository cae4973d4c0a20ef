"""In which directions may a station have looked: its walls against the plan of what the other stations see."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import rotation_site_scanner
from tasks.registration.planar import ScanPlanes
from tasks.registration.sighting import walls
from tasks.registration.station import StationPose

CELL_M: Final = 1.5
"""Of the plan in which walls are compared: what 0.25 degrees move at 300 m."""

STEP_RAD: Final = float(np.radians(0.2))
PEAK_RAD: Final = float(np.radians(1.0))
MOST_HEADINGS: Final = 24
GROUND_CELL_M: Final = 6.0
LEAST_GROUND_CELLS: Final = 5
RING: Final = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])


@dataclass(frozen=True, slots=True)
class Plan:
    """Cells in which placed stations see walls, and the height of the ground in coarser ones.

    ``wall_codes`` are sorted and hold the neighbours of cells, too; ``ground_codes`` (k,) are sorted, with ``ground_m``
    (k,).
    """

    wall_codes: NDArray[np.int64]
    ground_codes: NDArray[np.int64]
    ground_m: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PoseOfHeading:
    """Poses of a scanner for any heading: at a known place, or around a structure that it sees.

    Without ``sees_m`` it stands at ``place_m`` (3,); with it, so that what it sees at ``sees_m`` (2,) of its own frame
    lies at ``place_m``.
    """

    station: str
    place_m: NDArray[np.float64]
    sees_m: NDArray[np.float64] | None = None

    def pose(self, heading_rad: float) -> StationPose:
        """Pose for a heading."""
        rotation = rotation_site_scanner(heading_rad)
        if self.sees_m is None:
            return StationPose(self.station, rotation, self.place_m)
        return StationPose(self.station, rotation, self.place_m - rotation @ np.r_[self.sees_m, 0.0])


def draw_plan(stations: Sequence[ScanPlanes], poses: Sequence[StationPose]) -> Plan:
    """Draw the plan of what stations see, each at its pose."""
    stand = np.concatenate([pose.to_site(walls(one)) for one, pose in zip(stations, poses, strict=True)])
    lie = np.concatenate([pose.to_site(_flat(one)) for one, pose in zip(stations, poses, strict=True)])
    cells = np.unique(_cells(stand, CELL_M), axis=0)
    codes, heights = _lowest(lie)
    return Plan(np.unique(_code((cells[:, None, :] + RING).reshape(-1, 2))), codes, heights)


def likely_headings(plan: Plan, planes: ScanPlanes, poses: PoseOfHeading) -> list[float]:
    """Headings (rad) for which the walls of a scan fit the plan better than for those beside, the best first."""
    walls_m = walls(planes)
    if len(walls_m) == 0:
        return []
    # a near wall of many points counts no more than a far one of few
    _, first = np.unique(_code(_cells(walls_m, CELL_M / 2.0)), return_index=True)
    own = walls_m[np.sort(first)]
    headings = np.arange(0.0, 2.0 * np.pi, STEP_RAD)
    shares = np.array([_share(plan, poses.pose(float(heading)).to_site(own)) for heading in headings])
    likely: list[float] = []
    for i in np.argsort(-shares, kind="stable"):
        apart = [abs((headings[i] - other + np.pi) % (2.0 * np.pi) - np.pi) for other in likely]
        if all(angle > PEAK_RAD for angle in apart):
            likely.append(float(headings[i]))
        if len(likely) == MOST_HEADINGS:
            break
    return likely


def ground_offset_m(plan: Plan, planes: ScanPlanes, pose: StationPose) -> float | None:
    """How much higher the scan would have to be for its ground to lie on that of the others; None if nothing is shared."""
    codes, heights = _lowest(pose.to_site(_flat(planes)))
    shared, mine, theirs = np.intersect1d(codes, plan.ground_codes, return_indices=True)
    if len(shared) < LEAST_GROUND_CELLS:
        return None
    return float(np.median(plan.ground_m[theirs] - heights[mine]))


def _share(plan: Plan, walls_site_m: NDArray[np.float64]) -> float:
    return float(np.mean(_is_in(plan.wall_codes, _code(_cells(walls_site_m, CELL_M)))))


def _flat(planes: ScanPlanes) -> NDArray[np.float64]:
    lying = np.abs(planes.fine.normals[:, 2]) > 0.9
    return np.concatenate([planes.fine.points_m[lying], planes.coarse.points_m])


def _lowest(points_m: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Lowest point of each cell: codes, sorted, and heights."""
    codes = _code(_cells(points_m, GROUND_CELL_M))
    order = np.lexsort((points_m[:, 2], codes))
    unique, first = np.unique(codes[order], return_index=True)
    return unique, points_m[order][first, 2]


def _cells(points_m: NDArray[np.float64], cell_m: float) -> NDArray[np.int64]:
    return np.floor(points_m[:, :2] / cell_m).astype(np.int64)


def _code(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.asarray(cells[:, 0] * (1 << 24) + cells[:, 1])


def _is_in(sorted_codes: NDArray[np.int64], codes: NDArray[np.int64]) -> NDArray[np.bool_]:
    if len(sorted_codes) == 0:
        return np.zeros(len(codes), bool)
    place = np.minimum(np.searchsorted(sorted_codes, codes), len(sorted_codes) - 1)
    return np.asarray(sorted_codes[place] == codes)
