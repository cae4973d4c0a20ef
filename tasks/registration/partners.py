"""The nearest planes of a scan to those of another, looked up anew only where a motion may have changed them."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.registration.planar import PlanarCloud
from tasks.registration.station import StationPose

QUERIES: Final = 3000
"""Points of one scan that look for a partner in another; evenly taken, no chance."""

SLACK_M: Final = 0.1
"""So much farther than asked is searched: what lies beyond is known to be out of reach until a scan has moved by that."""

NOBODY: Final = -1


class Partners:
    """Points of a source and the nearest plane of the target to each, kept from one pose to the next.

    Every answer is that of a search at the present poses. A point that moved by less than half of what its second nearest is
    farther away than its nearest keeps it, so that nothing has to be searched for where poses hardly move.

    ``asked`` (q,) are indices of the source's planes.
    """

    def __init__(self, source: PlanarCloud, target: PlanarCloud) -> None:
        self.target = target
        self.asked = _evenly(len(source.points_m))
        self.points_m = np.ascontiguousarray(source.points_m[self.asked])
        self.normals = np.ascontiguousarray(source.normals[self.asked])
        self._searched_m = np.zeros_like(self.points_m)
        self._partner = np.full(len(self.asked), NOBODY)
        self._others_m = np.full(len(self.asked), -np.inf)

    def nearest(
        self, pose: StationPose, target_pose: StationPose, reach_m: float
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
        """Points (q, 3) in the site frame, nearest planes (q,) of the target, distances (q,), infinite beyond reach."""
        from tasks.registration.match_kernel import into_target, unsettled  # noqa: PLC0415 (slow to import)

        placed_m, local_m = into_target(self.points_m, _frame(pose), _frame(target_pose))
        anew, distance = unsettled(
            local_m, self._searched_m, self._partner, self._others_m, self.target.points_m, reach_m
        )
        if len(anew):
            distance[anew] = self._search(local_m, anew, reach_m)
        return placed_m, self._partner, np.where(distance < reach_m, distance, np.inf)

    def _search(
        self, local_m: NDArray[np.float64], anew: NDArray[np.int64], reach_m: float
    ) -> NDArray[np.float64]:
        """Look up the nearest of some points; give how far it is."""
        searched_m = reach_m + SLACK_M
        distance, index = self.target.tree.query(local_m[anew], k=2, distance_upper_bound=searched_m)
        self._searched_m[anew] = local_m[anew]
        self._partner[anew] = np.where(np.isfinite(distance[:, 0]), index[:, 0], NOBODY)
        self._others_m[anew] = np.minimum(distance[:, 1], searched_m)
        return np.asarray(distance[:, 0])


def _frame(pose: StationPose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return np.ascontiguousarray(pose.rotation), pose.position_m


def _evenly(n: int) -> NDArray[np.int64]:
    """Indices of the points that are asked: all, or so many, evenly taken."""
    if n <= QUERIES:
        return np.arange(n)
    return np.linspace(0, n - 1, QUERIES).astype(np.int64)
