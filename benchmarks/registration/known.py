"""An epoch whose truth is known: what the crew states, and what is so."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import azimuth_deg, rotation_site_scanner
from tasks.geometry.rotations import rotation_from_vector
from tasks.preprocessing import StructurePrior
from tasks.registration import InstrumentSigmas, ShaftHint, StationPose, StationScan


@dataclass(frozen=True, slots=True)
class KnownStation:
    """A scan as the crew states it, and its true pose; the level is in it where it is known.

    ``tilt_rad`` about east and north is a blunder of the levelling: in the true pose, and known to true poses.
    """

    scan: StationScan
    true_pose: StationPose
    tilt_rad: tuple[float, float] = (0.0, 0.0)

    @property
    def name(self) -> str:
        """Id of the station."""
        return self.scan.station

    @property
    def plumb_pose(self) -> StationPose:
        """True position and heading, plumb but for a blunder: what a perfect registration without levels gives."""
        plumb = rotation_site_scanner(heading_rad(self.true_pose))
        tilt = rotation_from_vector(np.array([*self.tilt_rad, 0.0]))
        return StationPose(self.name, tilt @ plumb, self.true_pose.position_m)


@dataclass(frozen=True, slots=True)
class KnownEpoch:
    """Stations of one epoch and the true lean vector (2,), east and north."""

    label: str
    stations: tuple[KnownStation, ...]
    true_lean: NDArray[np.float64]
    sigmas: InstrumentSigmas
    prior: StructurePrior

    @property
    def scans(self) -> list[StationScan]:
        """The scans with their stated poses."""
        return [station.scan for station in self.stations]

    @property
    def hint(self) -> ShaftHint:
        """What a campaign file says of the shaft."""
        return ShaftHint(self.prior.base_xy_m, self.prior.shaft_z_m, self.prior.radius_m)

    def station(self, name: str) -> KnownStation:
        """The station of that name."""
        return next(station for station in self.stations if station.name == name)

    def with_stations(self, stations: list[KnownStation]) -> "KnownEpoch":
        """The same epoch with other stations."""
        return replace(self, stations=tuple(stations))


def heading_rad(pose: StationPose) -> float:
    """Azimuth of the scanner's +y axis, clockwise from north."""
    forward = pose.rotation[:, 1]
    return float(np.radians(azimuth_deg(float(forward[0]), float(forward[1]))))
