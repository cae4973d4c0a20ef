"""Change between two epochs: what they have in common cancelled, each quantity tested by itself, and where it happened."""

from tasks.change.centres import AxisError, CentreChange, Centres, compare_centres
from tasks.change.chi_square import SIGNIFICANT_P, ChangeTest, chi_square_test, detectable_factor
from tasks.change.common_heights import SliceAxis, at_common_heights, same_heights
from tasks.change.coverage import SeenSurface, likeness
from tasks.change.difference import (
    FREE,
    RADIUS_HELD,
    SUM_OF_BOTH,
    FrameOf,
    ParameterChange,
    hold_radius,
    parameter_change,
)

__all__ = [
    "FREE",
    "RADIUS_HELD",
    "SIGNIFICANT_P",
    "SUM_OF_BOTH",
    "AxisError",
    "CentreChange",
    "Centres",
    "ChangeTest",
    "FrameOf",
    "ParameterChange",
    "SeenSurface",
    "SliceAxis",
    "at_common_heights",
    "chi_square_test",
    "compare_centres",
    "detectable_factor",
    "hold_radius",
    "likeness",
    "parameter_change",
    "same_heights",
]
