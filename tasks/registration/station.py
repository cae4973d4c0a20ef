"""What registration takes and gives: scans with stated poses in, adjusted poses with covariance out."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tasks.registration.even_sample import Cloud

Ties = Literal["common shaft", "none"]


@dataclass(frozen=True, slots=True)
class StationScan:
    """A scan with the pose that the crew states for it.

    ``points_m`` is (n, 3) in the scanner frame, an array or a cloud that is read in chunks; ``position_m`` (3,) the scanner
    in the site frame; ``heading_rad`` the azimuth of the scanner's +y axis, clockwise from grid north. None where the crew
    states nothing: it is then found from the shaft and the other stations.
    """

    station: str
    points_m: Cloud
    position_m: NDArray[np.float64] | None
    heading_rad: float | None


@dataclass(frozen=True, slots=True)
class ShaftHint:
    """What is roughly known of the structure, in the site frame: a help for the start, never an observation.

    ``shaft_z_m`` and ``radius_m`` are at its two ends, the lower first. Where ``ties`` says "common shaft", the stations
    are also tied by the one axis and the one radius at each height that all of them see; it must be round for that.
    """

    base_xy_m: tuple[float, float]
    shaft_z_m: tuple[float, float]
    radius_m: tuple[float, float]
    ties: Ties = "common shaft"


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
    """How well a station is placed; angles in radians, lengths in metres.

    ``start`` says where the start of the adjustment came from: "as stated", or what was found in its place and why.
    ``correction_m`` (3,) is the adjusted minus the stated position, None where none is stated. ``normalised`` has the
    corrections of the stated pose in the order of ``tasks.conventions``, each in units of its own standard deviation
    (Baarda's w), None where nothing is stated or the scans say too little to test it.
    """

    station: str
    heading_rad: float
    heading_correction_rad: float | None
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
    start: str
    correction_m: NDArray[np.float64] | None
    normalised: tuple[float | None, ...]


@dataclass(frozen=True, slots=True)
class PairDiagnosis:
    """How two stations of an epoch agree, at the adjusted poses.

    ``overlap`` is the share of the first station's sampled planes that match the other. The residuals are robust
    scales of the distances along the normal, on the shaft and on everything else; None with too few matches.
    ``closure_m`` and ``closure_rad`` are the worst of the loops through this pair and a third station, each pair
    adjusted alone: the length of the translation at the structure, and the angle. None where no loop closes.
    """

    station: str
    other: str
    overlap: float
    n_matches: int
    rmse_m: float | None
    rmse_shaft_m: float | None
    rmse_background_m: float | None
    closure_m: float | None
    closure_rad: float | None


@dataclass(frozen=True, slots=True)
class RefusedStation:
    """A station that was left out of the adjustment, and why."""

    station: str
    reason: str


@dataclass(frozen=True, slots=True)
class Registration:
    """Adjusted poses of an epoch and what is known of them.

    ``covariance`` is (6 n, 6 n) in the order of ``tasks.conventions``: the stations one after the
    other, each with rotations about east, north, up (rad), then shifts east, north, up (m).
    Poses and diagnoses are of the stations that are used; ``refused`` names the others. ``warnings`` are about the epoch as
    a whole. ``frame_covariance`` (6 n, 6 n) is the part of ``covariance`` that the frame of the reference epoch brings
    along, where stable surroundings tie the epoch to it; None where nothing does.
    """

    poses: tuple[StationPose, ...]
    covariance: NDArray[np.float64]
    diagnoses: tuple[PoseDiagnosis, ...]
    iterations: int
    pairs: tuple[PairDiagnosis, ...] = ()
    refused: tuple[RefusedStation, ...] = ()
    warnings: tuple[str, ...] = ()
    frame_covariance: NDArray[np.float64] | None = None
