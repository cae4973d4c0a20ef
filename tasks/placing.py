"""Bring the scans of an epoch into one cloud of the site frame, each point knowing its station."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.registration import StationPose


@dataclass(frozen=True, slots=True)
class PlacedCloud:
    """Points (n, 3) in the site frame, metres, and the index (n,) of the station that saw them."""

    points_m: NDArray[np.float64]
    station_index: NDArray[np.uint16]

    def shares(self, n_stations: int) -> NDArray[np.float64]:
        """Share (n_stations,) of every station in the points."""
        counts = np.bincount(self.station_index, minlength=n_stations).astype(np.float64)
        return np.asarray(counts / counts.sum())


def place(clouds_m: Sequence[NDArray[np.float64]], poses: Sequence[StationPose]) -> PlacedCloud:
    """Transform scans (n_i, 3), scanner frames, by their poses and join them in the order given.

    Raises
    ------
    ShapeError
        If there are not as many poses as scans, or none.
    """
    if not clouds_m or len(clouds_m) != len(poses):
        raise ShapeError(f"place needs as many poses as scans, got {len(poses)} and {len(clouds_m)}")
    points = np.concatenate([pose.to_site(cloud) for cloud, pose in zip(clouds_m, poses, strict=True)])
    index = np.repeat(np.arange(len(poses), dtype=np.uint16), [len(cloud) for cloud in clouds_m])
    return PlacedCloud(points, index)
