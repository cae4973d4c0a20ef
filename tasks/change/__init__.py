"""Change between two epochs: what they have in common cancelled, each quantity tested by itself, and where it happened."""

from tasks.change.centres import CentreChange, Centres, compare_centres
from tasks.change.chi_square import SIGNIFICANT_P, ChangeTest, chi_square_test, detectable_factor
from tasks.change.coverage import SeenSurface, likeness
from tasks.change.difference import FREE, RADIUS_HELD, ParameterChange, hold_radius, parameter_change

__all__ = [
    "FREE",
    "RADIUS_HELD",
    "SIGNIFICANT_P",
    "CentreChange",
    "Centres",
    "ChangeTest",
    "ParameterChange",
    "SeenSurface",
    "chi_square_test",
    "compare_centres",
    "detectable_factor",
    "hold_radius",
    "likeness",
    "parameter_change",
]
