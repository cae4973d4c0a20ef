"""Cut a shaft into horizontal slices: which heights, and which points belong to each (paper 2.2.1).

A scheme is one file of this folder that defines ``SCHEME``; it is found by itself.
"""

from typing import Final

from tasks.geometry.variants import discover
from tasks.slicing.adaptive import AdaptiveSlices, adaptive_slices
from tasks.slicing.center_information import RingPoints
from tasks.slicing.cut import Rows, cut_between, cut_slices, rows_between_edges, rows_of_slices
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
    "Rows",
    "SlicingScheme",
    "ThicknessLimit",
    "adaptive_slices",
    "cut_between",
    "cut_slices",
    "linear_limit",
    "rows_between_edges",
    "rows_of_slices",
    "slice_heights",
    "user_scheme",
]
