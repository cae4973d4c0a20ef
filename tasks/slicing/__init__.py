"""Cut a shaft into horizontal slices: which heights, and which points belong to each (paper 2.2.1).

A scheme is one file of this folder that defines ``SCHEME``; it is found by itself.
"""

from typing import Final

from tasks.geometry.variants import discover
from tasks.slicing.adaptive import AdaptiveSlices, adaptive_slices
from tasks.slicing.center_information import RingPoints
from tasks.slicing.cut import cut_between, cut_slices
from tasks.slicing.heights import slice_heights
from tasks.slicing.linearity import ThicknessLimit, linear_limit
from tasks.slicing.scheme import AdaptiveCut, SlicingScheme, user_scheme

SCHEMES: Final[dict[str, SlicingScheme]] = dict(sorted(discover(__name__, "SCHEME", SlicingScheme).items()))
"""The schemes that are shipped, by name."""

__all__ = [
    "SCHEMES",
    "AdaptiveCut",
    "AdaptiveSlices",
    "RingPoints",
    "SlicingScheme",
    "ThicknessLimit",
    "adaptive_slices",
    "cut_between",
    "cut_slices",
    "linear_limit",
    "slice_heights",
    "user_scheme",
]
