"""Cut a shaft into horizontal slices: which heights, and which points belong to each (paper 2.2.1).

A scheme is one file of this folder that defines ``SCHEME``; it is found by itself.
"""

from typing import Final

from tasks.geometry.variants import discover
from tasks.slicing.cut import cut_slices
from tasks.slicing.heights import slice_heights
from tasks.slicing.scheme import SlicingScheme, user_scheme

SCHEMES: Final[dict[str, SlicingScheme]] = dict(sorted(discover(__name__, "SCHEME", SlicingScheme).items()))
"""The schemes that are shipped, by name."""

__all__ = ["SCHEMES", "SlicingScheme", "cut_slices", "slice_heights", "user_scheme"]
