"""How far from round a profile is."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.profile import Basis

DIRECTIONS: Final = 720
"""Directions in which a profile is evaluated: every half degree."""


@dataclass(frozen=True, slots=True)
class OutOfRound:
    """Roundness, ovality and the azimuth in [0, 180) of the larger diameter, clockwise from north."""

    roundness_m: float
    ovality_m: float
    ovality_azimuth_deg: float


def axis_azimuth_deg(angle_rad: float) -> float:
    """Azimuth in [0, 180) of a line whose direction is counted counter-clockwise from east, degrees."""
    azimuth = (90.0 - float(np.degrees(angle_rad))) % 180.0
    # a direction of -1e-15 becomes 180.0, which is 0
    return azimuth if azimuth < 180.0 else 0.0


def out_of_round(basis: Basis, coefficients_m: NDArray[np.float64]) -> OutOfRound:
    """Evaluate a profile all around; the ovality is the amplitude of its second harmonic."""
    turn = np.exp(2j * np.pi * np.arange(DIRECTIONS) / DIRECTIONS)
    profile = coefficients_m @ basis.rows(turn).values
    second = 2 * np.mean(profile * turn * turn)
    return OutOfRound(
        roundness_m=float(np.ptp(profile)),
        ovality_m=float(np.abs(second)),
        ovality_azimuth_deg=axis_azimuth_deg(float(np.angle(second)) / 2),
    )
