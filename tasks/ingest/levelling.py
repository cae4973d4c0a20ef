"""Level a scan by the pose that its file states, and tell where a scan is not plumb by it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.geometry.rotations import rotation_from_vector
from tasks.ingest.scan import FilePose, Levelling

PLUMB_DEG: Final = 0.01
"""A scanner that levels itself is plumb within this (36 arc seconds); a pose beyond it says that the scan is tilted."""


@dataclass(frozen=True, slots=True)
class Levelled:
    """Points (n, 3) of a scan, the pose that its file states of them, and notes worth telling."""

    points_m: NDArray[np.float64]
    pose: FilePose | None
    notes: tuple[str, ...]


def level_scan(
    path: Path, points_m: NDArray[np.float64], pose: FilePose | None, levelling: Levelling
) -> Levelled:
    """Take points (n, 3) of the scanner frame as plumb, or turn them by the tilt of their pose.

    The tilt is the smallest rotation that makes the vertical of the file the z axis: what is left of the pose is a
    heading and a shift.

    Raises
    ------
    InputError
        If the file is to level the scan and states no pose.
    """
    if levelling == "scanner":
        return Levelled(points_m, pose, () if pose is None else _off_plumb(pose))
    if pose is None:
        raise InputError(
            f'{path}: needs the pose of the scan for pose = "file", came a file that states none; '
            "write position_m and heading_deg instead"
        )
    tilt = _tilt(pose.rotation)
    left = FilePose(pose.rotation @ tilt.T, pose.translation)
    return Levelled(points_m @ tilt.T, left, _unregistered(pose))


def _off_plumb(pose: FilePose) -> tuple[str, ...]:
    """Say of the pose of a scan that is taken as plumb that it is not."""
    off_deg = float(np.degrees(np.arctan2(np.hypot(*pose.rotation[2, :2]), pose.rotation[2, 2])))
    if off_deg <= PLUMB_DEG:
        return ()
    return (
        f"its file states a pose {off_deg:.3f} deg off plumb, and the points are taken as plumb; "
        'write pose = "file" if they are in the frame of the tilted scanner',
    )


def _tilt(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Smallest rotation (3, 3) that takes the vertical, as the scanner sees it, to the scanner's z axis."""
    vertical = rotation[2]
    across = np.cross(vertical, (0.0, 0.0, 1.0))
    sine = float(np.linalg.norm(across))
    if sine < 1e-15:
        # upside down, any horizontal axis turns it back by the same angle
        return np.eye(3) if vertical[2] > 0.0 else np.diag([1.0, -1.0, -1.0])
    return rotation_from_vector(across / sine * np.arctan2(sine, vertical[2]))


def _unregistered(pose: FilePose) -> tuple[str, ...]:
    if np.array_equal(pose.rotation, np.eye(3)) and not np.any(pose.translation):
        return ("its file states neither a turn nor a shift; is it the export of the registered scan",)
    return ()
