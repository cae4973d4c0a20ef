"""What registration takes and gives: scans with stated poses in, adjusted poses with covariance out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class StationScan:
    """A scan with the pose that the crew states for it.

    ``points_m`` is (n, 3) in the scanner frame; ``position_m`` (3,) the scanner in the site frame;
    ``heading_rad`` the azimuth of the scanner's +y axis, clockwise from grid north.
    """

    station: str
    points_m: NDArray[np.float64]
    position_m: NDArray[np.float64]
    heading_rad: float


@dataclass(frozen=True, slots=True)
class InstrumentSigmas:
    """Standard deviations that hold a pose before any scan is compared with another."""

    position_m: tuple[float, float]
    """Horizontal component and vertical."""
    heading_rad: float
    level_rad: float
    """One component of the direction of the scanner's z axis."""


@dataclass(frozen=True, slots=True)
class StationPose:
    """T_site_scanner: ``points_site = rotation @ points_scanner + position``."""

    station: str
    rotation: NDArray[np.float64]
    position_m: NDArray[np.float64]

    def to_site(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) of the scanner frame in the site frame."""
        return np.asarray(points_m @ self.rotation.T + self.position_m)


@dataclass(frozen=True, slots=True)
class PoseDiagnosis:
    """How well a station is placed; angles in radians, lengths in metres."""

    station: str
    heading_rad: float
    heading_correction_rad: float
    level_east_rad: float
    level_north_rad: float
    overlap: float | None
    rmse_m: float | None
    sigma_heading_rad: float
    sigma_level_rad: float
    sigma_position_m: float
    weakest_direction: str | None
    state: str
    reason: str | None


@dataclass(frozen=True, slots=True)
class Registration:
    """Adjusted poses of an epoch and what is known of them.

    ``covariance`` is (6 n, 6 n) in the order of ``tasks.conventions``: the stations one after the
    other, each with rotations about east, north, up (rad), then shifts east, north, up (m).
    """

    poses: tuple[StationPose, ...]
    covariance: NDArray[np.float64]
    diagnoses: tuple[PoseDiagnosis, ...]
    iterations: int
