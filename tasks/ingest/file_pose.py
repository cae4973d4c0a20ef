"""Poses as files state them: checked, and put to use."""

import math
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.geometry.rotations import nearest_rotation
from tasks.ingest.scan import FilePose
from tasks.ingest.soundness import LARGEST_NUMBER

ROUNDING: Final = 2e-5
"""Of a rotation written with five decimals: ``R R^T`` is off by at most 2 * sqrt(3) * 5e-6; some 2" of direction."""

UNIT_NORM: Final = 1e-3
"""By which a written quaternion may miss the norm 1; scaling it back is exact."""

PIECE: Final = 1 << 18
"""Points, placed at a time."""


def pose_of_matrix(
    path: Path, where: str, rotation: NDArray[np.float64], translation: NDArray[np.float64]
) -> FilePose:
    """Pose ``points_file = rotation @ points_scanner + translation``, its rotation freed from rounding.

    Parameters
    ----------
    path, where
        For the message: the file, and what in it states the pose.
    rotation : (3, 3) array
        As written.
    translation : (3,) array
        In the unit of the file.

    Raises
    ------
    InputError
        If the matrix mirrors, scales or shears beyond rounding, or is not finite.
    """
    if not (np.abs(np.vstack([rotation, translation])) < LARGEST_NUMBER).all():
        raise InputError(
            f"{path}: needs a finite pose, came NaN, infinity or a number beyond all coordinates in {where}; export again"
        )
    gram = rotation @ rotation.T
    if np.linalg.det(rotation) < 0.0:
        fault = "a mirror (determinant below 0)"
    elif np.abs(np.diag(gram) - 1.0).max() > ROUNDING:
        scales = ", ".join(f"{scale:.6g}" for scale in np.linalg.norm(rotation, axis=0))
        fault = f"axes of lengths {scales}"
    elif np.abs(gram - np.eye(3)).max() > ROUNDING:
        fault = f"axes that are no right angles (off by {np.abs(gram - np.eye(3)).max():.2g})"
    else:
        return FilePose(nearest_rotation(rotation), translation.copy())
    raise InputError(
        f"{path}: needs a rotation and a translation with at least five decimals, came {fault} in {where}; "
        "export again without scaling, in metres"
    )


def pose_of_quaternion(
    path: Path, where: str, quaternion: NDArray[np.float64], translation: NDArray[np.float64]
) -> FilePose:
    """Pose of a quaternion (4,) in the order w, x, y, z and a translation (3,) in the unit of the file.

    Raises
    ------
    InputError
        If the quaternion is not of norm 1, or anything is not finite.
    """
    norm = math.hypot(*quaternion)  # of huge numbers, too
    if not abs(norm - 1.0) <= UNIT_NORM or not np.isfinite(translation).all():
        raise InputError(
            f"{path}: needs a finite pose with a quaternion of norm 1, came norm {norm:.4g} in {where}; export again"
        )
    w, x, y, z = quaternion / norm
    rotation = np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
    return FilePose(rotation, translation.copy())


def place_points(pose: FilePose, values: NDArray[np.float64]) -> None:
    """Turn points (n, 3) from the frame of their scanner into that of the file, in place.

    Points at (0, 0, 0) stay there: they are beams without a return, and whoever counts those must find them.
    """
    for start in range(0, len(values), PIECE):
        piece = values[start : start + PIECE]
        is_return = (piece != 0.0).any(axis=1)
        # what is not finite is refused by those who check all formats
        with np.errstate(invalid="ignore", over="ignore"):
            piece[is_return] = piece[is_return] @ pose.rotation.T + pose.translation
