"""The pose of a scan in an E57 file: a unit quaternion and a translation (ASTM E2807, 8.4.4)."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import InputError
from tasks.conventions import ARCSEC_RAD
from tasks.ingest.e57_xml import Element
from tasks.ingest.file_pose import pose_of_quaternion
from tasks.ingest.scan import FilePose
from tasks.ingest.soundness import LARGEST_NUMBER
from tasks.ingest.text_layout import is_number

SIX_DIGITS: Final = 2e-6
"""What six digits behind the point leave open of the length of a quaternion, and a little more."""


@dataclass(frozen=True, slots=True)
class StatedPose:
    """A pose, and by how much its quaternion misses the length 1, which tells how roughly it was written."""

    pose: FilePose
    defect: float

    def notes(self) -> tuple[str, ...]:
        """A note if the directions are rougher than a level."""
        if self.defect <= SIX_DIGITS:
            return ()
        return (
            f"its file states a quaternion that misses the length 1 by {self.defect:.2g}: the rotation is good to some "
            f"{2.0 * self.defect / ARCSEC_RAD:.0f} arc seconds only; export the pose with more digits",
        )


def read_pose(path: Path, place: str, scan: Element) -> StatedPose | None:
    """The pose that a scan states, None where it states none; a part that is missing is the identity.

    Raises
    ------
    InputError
        If a number is not finite, or the quaternion is not of length 1.
    """
    pose = scan.child("pose")
    if pose is None:
        return None
    rotation, translation = pose.child("rotation"), pose.child("translation")
    quaternion = np.array([1.0, 0.0, 0.0, 0.0]) if rotation is None else _numbers(rotation, "wxyz")
    shift = np.zeros(3) if translation is None else _numbers(translation, "xyz")
    if not (np.abs(np.concatenate([quaternion, shift])) < LARGEST_NUMBER).all():
        raise InputError(
            f"{path}: needs a pose of finite numbers w, x, y, z and x, y, z, came {quaternion.tolist()} and "
            f"{shift.tolist()} in {place}; export the file again"
        )
    defect = abs(float(np.linalg.norm(quaternion)) - 1.0)
    return StatedPose(pose_of_quaternion(path, place, quaternion, shift), defect)


def _numbers(parent: Element, names: str) -> NDArray[np.float64]:
    return np.array([number_in(parent.child(name)) for name in names])


def number_in(element: Element | None) -> float:
    """The number in an element, NaN where there is none; an empty element means 0 by the standard."""
    if element is None:
        return math.nan
    value = plain_number(element.text or "0")
    if element.attributes.get("type") != "ScaledInteger":
        return value
    scale = plain_number(element.attributes.get("scale", "1"))
    offset = plain_number(element.attributes.get("offset", "0"))
    return value * scale + offset


def plain_number(text: str) -> float:
    """The number that a text is in XML, NaN where it is none: no underscores, no digits of other scripts."""
    return float(text) if text.isascii() and is_number(text) else math.nan
