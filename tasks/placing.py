"""Bring the scans of an epoch into the site frame, each point knowing its station: at once, or piece by piece."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.registration import Cloud, StationPose, sampled


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


@dataclass(frozen=True, slots=True, eq=False)
class PlacedScan:
    """A scan (n, 3), an array or a cloud that is read in chunks, seen through its pose: in the site frame, metres."""

    cloud: Cloud
    pose: StationPose

    def __len__(self) -> int:
        """Count its points."""
        return len(self.cloud)

    def chunks(self, size: int) -> Iterator[NDArray[np.float64]]:
        """Give all points in order, as arrays (m, 3) of at most ``size``."""
        for piece_m in _pieces(self.cloud, size):
            yield self._placed(piece_m)

    def sample(self, most: int) -> NDArray[np.float64]:
        """Give an even sample (m, 3) of at most ``most`` points; all, in order, where there are no more."""
        return self._placed(sampled(self.cloud, most))

    def _placed(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        from tasks.geometry.motion_kernel import move_points  # noqa: PLC0415 (compiled code is slow to import, and every command reads settings)

        placed_m = np.empty(points_m.shape)
        move_points(points_m, self.pose.rotation, self.pose.position_m, placed_m)
        return placed_m


def place_scans(clouds_m: Sequence[Cloud], poses: Sequence[StationPose]) -> list[PlacedScan]:
    """See scans through their poses; nothing is read yet.

    Raises
    ------
    ShapeError
        If there are not as many poses as scans, or none.
    """
    if not clouds_m or len(clouds_m) != len(poses):
        raise ShapeError(f"place_scans needs as many poses as scans, got {len(poses)} and {len(clouds_m)}")
    return [PlacedScan(cloud, pose) for cloud, pose in zip(clouds_m, poses, strict=True)]


def _pieces(cloud: Cloud, size: int) -> Iterable[NDArray[np.float64]]:
    if isinstance(cloud, np.ndarray):
        return (cloud[start : start + size] for start in range(0, len(cloud), size))
    return cloud.chunks(size)
