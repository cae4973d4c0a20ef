"""Tilt: from the direction of the axis to the figures that people ask for, with their uncertainty."""

from tasks.tilt.paper import beta_deg, beta_of_reversed_axis_deg, deviation_m, tilt_rad, verticality
from tasks.tilt.parameters import TiltParameters, lean_of_direction, tilt_parameters

__all__ = [
    "TiltParameters",
    "beta_deg",
    "beta_of_reversed_axis_deg",
    "deviation_m",
    "lean_of_direction",
    "tilt_parameters",
    "tilt_rad",
    "verticality",
]
