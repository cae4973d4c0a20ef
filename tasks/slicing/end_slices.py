"""Scheme E: the slices at both ends, their centres joined by a line."""

from typing import Final

from tasks.slicing.scheme import SlicingScheme

SCHEME: Final = SlicingScheme("E", "both ends", ends_only=True, axis="two_points")
