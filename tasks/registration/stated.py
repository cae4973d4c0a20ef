"""What the crew and the instrument state of a pose, as observations of the adjustment."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import rotation_site_scanner
from tasks.registration.station import InstrumentSigmas, StationPose, StationScan

HELD_LOOSELY: Final = 1e-6
"""Share of its information that a statement keeps which was found to be wrong: it then weighs nothing, but a
direction that no scan sees stays where it was stated, with a standard deviation of a thousand times as much."""

PARTS: Final = {"level": (0, 1), "heading": (2,), "position": (3, 4), "height": (5,)}
"""What is stated and tested together, by its parameters in the order of ``tasks.conventions``."""


@dataclass(frozen=True, slots=True)
class StatedPose:
    """A stated pose and how much each of its parameters weighs.

    ``information`` (6,) is 1 / sigma^2; ``is_stated`` (6,) is False where nothing is stated and ``pose`` holds what was
    found in its place.
    """

    pose: StationPose
    information: NDArray[np.float64]
    is_stated: NDArray[np.bool_]

    def without(self, part: str) -> "StatedPose":
        """Give up what is stated of a part: it hardly weighs any longer."""
        information = self.information.copy()
        information[list(PARTS[part])] *= HELD_LOOSELY
        return StatedPose(self.pose, information, self.is_stated)


def stated_pose(scan: StationScan, found: StationPose, sigmas: InstrumentSigmas) -> StatedPose:
    """Pose that a scan states, plumb; what it does not state is taken from ``found`` and hardly weighs."""
    rotation = found.rotation if scan.heading_rad is None else rotation_site_scanner(scan.heading_rad)
    position = found.position_m if scan.position_m is None else np.asarray(scan.position_m, dtype=np.float64)
    stated = StatedPose(
        StationPose(scan.station, rotation, position), stated_information(sigmas), np.ones(6, bool)
    )
    missing = [] if scan.heading_rad is not None else ["heading"]
    missing += [] if scan.position_m is not None else ["position", "height"]
    is_stated = stated.is_stated.copy()
    for part in missing:
        stated = stated.without(part)
        is_stated[list(PARTS[part])] = False
    return StatedPose(stated.pose, stated.information, is_stated)


def stated_information(sigmas: InstrumentSigmas) -> NDArray[np.float64]:
    """Diagonal (6,) of the information that level, heading and GNSS give of one pose."""
    horizontal, vertical = sigmas.position_m
    level, heading = sigmas.level_rad, sigmas.heading_rad
    return np.asarray(1.0 / np.array([level, level, heading, horizontal, horizontal, vertical]) ** 2)
