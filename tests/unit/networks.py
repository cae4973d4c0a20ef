"""Shafts seen by stations about them, and the registrations that go with it, without any scan."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD
from tasks.coverage import Coverage, count_coverage
from tasks.preprocessing import ShaftModel
from tasks.registration import InstrumentSigmas, Registration, StationPose, registered_cloud

SHAFT_Z_M = (2.0, 102.0)
MODEL = ShaftModel(
    0.3, -0.2, 0.007, -0.0057, (2.0, 50.0, 102.0), (4.6, 3.6, 2.7), (0.0,) * 3, (0.0,) * 3, 0.01
)
DISTANCE_M = 250.0


def sigmas(level_arcsec: float = 2.9, heading_arcsec: float = 10.0) -> InstrumentSigmas:
    return InstrumentSigmas((0.015, 0.0225), heading_arcsec * ARCSEC_RAD, level_arcsec * ARCSEC_RAD)


def registration(azimuths_deg: Sequence[float], stated: InstrumentSigmas) -> Registration:
    """Stations about the axis whose poses are as uncertain as stated, independently."""
    ones = [registered_cloud(f"ST{i:02d}", stated) for i in range(1, len(azimuths_deg) + 1)]
    covariance = np.kron(np.eye(len(ones)), ones[0].covariance)
    poses = tuple(
        StationPose(one.poses[0].station, np.eye(3), position_m(azimuth))
        for one, azimuth in zip(ones, azimuths_deg, strict=True)
    )
    return Registration(poses, covariance, tuple(one.diagnoses[0] for one in ones), iterations=0)


def position_m(azimuth_deg: float) -> NDArray[np.float64]:
    a = np.radians(azimuth_deg)
    return np.array([DISTANCE_M * np.sin(a), DISTANCE_M * np.cos(a), 1.6])


def seen_from(
    azimuths_deg: Sequence[float], n: int = 8_000, seed: int = 1
) -> tuple[NDArray[np.float64], NDArray[np.uint16]]:
    """Points (k, 3) of the half shafts that stations at these azimuths see, and which of them sees each."""
    rng = np.random.default_rng(seed)
    parts = []
    for azimuth in azimuths_deg:
        z = rng.uniform(*SHAFT_Z_M, n)
        # as dense as the surface turns towards the scanner
        around = np.radians(azimuth) + np.arcsin(rng.uniform(-1.0, 1.0, n))
        radius = MODEL.radius_at(z) + MODEL.noise_sigma_m * rng.normal(size=n)
        xy = MODEL.axis_at(z) + radius[:, None] * np.column_stack([np.sin(around), np.cos(around)])
        parts.append(np.column_stack([xy, z]))
    return np.concatenate(parts), np.repeat(np.arange(len(parts), dtype=np.uint16), n)


def coverage_from(azimuths_deg: Sequence[float], n: int = 8_000) -> Coverage:
    points_m, station_index = seen_from(azimuths_deg, n)
    return count_coverage(points_m, station_index, MODEL, SHAFT_Z_M, len(azimuths_deg))


def with_more_points(coverage: Coverage, factor: int) -> Coverage:
    """The same pieces of the surface with many times the points."""
    return replace(coverage, counts=coverage.counts * factor, off_sum_m=coverage.off_sum_m * factor)
