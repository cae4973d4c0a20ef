"""A courtyard of walls and ground, small enough to register in a second, with everything seen from everywhere."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD, rotation_site_scanner
from tasks.geometry.rotations import rotation_from_vector
from tasks.registration import InstrumentSigmas, ShaftHint, StationPose, StationScan

SIGMAS = InstrumentSigmas((0.015, 0.0225), float(np.radians(0.15)), float(np.radians(0.0008)))
HALF_M = 30.0
TALL_M = 10.0
NOISE_M = 0.003
POINTS = 12_000
PLACES = {
    "ST01": (0.3, (8.0, -5.0, 1.6)),
    "ST02": (2.0, (-9.0, -6.0, 1.7)),
    "ST03": (4.0, (3.0, 11.0, 1.8)),
    "ST04": (5.0, (-4.0, 2.0, 1.5)),
}
CORNER = ShaftHint((HALF_M, HALF_M), (-1.0, TALL_M + 1.0), (15.0, 15.0))
"""Not a shaft at all: a part of the walls that can be counted apart."""


@dataclass(frozen=True)
class Courtyard:
    scans: tuple[StationScan, ...]
    truth: tuple[StationPose, ...]

    def stated_off(self, i: int, off_m: tuple[float, float, float]) -> list[StationScan]:
        position = self.scans[i].position_m
        assert position is not None
        return self.with_scan(i, replace(self.scans[i], position_m=position + np.array(off_m)))

    def turned(self, i: int, turn_rad: float) -> list[StationScan]:
        heading = self.scans[i].heading_rad
        assert heading is not None
        return self.with_scan(i, replace(self.scans[i], heading_rad=heading + turn_rad))

    def out_of_level(self, i: int, east_arcsec: float, north_arcsec: float) -> list[StationScan]:
        lean = rotation_from_vector(ARCSEC_RAD * np.array([east_arcsec, north_arcsec, 0.0]))
        before = self.truth[i].rotation
        points = self.scans[i].points_m @ (before.T @ lean.T @ before).T
        return self.with_scan(i, replace(self.scans[i], points_m=points))

    def with_scan(self, i: int, scan: StationScan) -> list[StationScan]:
        return [scan if k == i else other for k, other in enumerate(self.scans)]


def courtyard_points(rng: np.random.Generator) -> NDArray[np.float64]:
    k = POINTS // 5
    ground = np.column_stack([rng.uniform(-HALF_M, HALF_M, (k, 2)), np.zeros(k)])
    parts = [ground]
    for side in (-HALF_M, HALF_M):
        along, up = rng.uniform(-HALF_M, HALF_M, (2, k)), rng.uniform(0.0, TALL_M, (2, k))
        parts.append(np.column_stack([along[0], np.full(k, side), up[0]]))
        parts.append(np.column_stack([np.full(k, side), along[1], up[1]]))
    points = np.vstack(parts)
    return points + NOISE_M * rng.normal(size=points.shape)


def draw_courtyard(seed: int) -> Courtyard:
    """Scans with levels, headings and positions that are off by their sigmas."""
    rng = np.random.default_rng(seed)
    scans, truth = [], []
    for name, (heading, place) in PLACES.items():
        level = rotation_from_vector(np.array([*(SIGMAS.level_rad * rng.normal(size=2)), 0.0]))
        pose = StationPose(name, level @ rotation_site_scanner(heading), np.array(place))
        points = (courtyard_points(rng) - pose.position_m) @ pose.rotation
        stated = pose.position_m + np.array([0.015, 0.015, 0.0225]) * rng.normal(size=3)
        scans.append(StationScan(name, points, stated, heading + SIGMAS.heading_rad * rng.normal()))
        truth.append(pose)
    return Courtyard(tuple(scans), tuple(truth))
