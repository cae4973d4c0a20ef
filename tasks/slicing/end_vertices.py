"""Scheme F: the slices at both ends, centres from the vertices of the contour (the control of the paper)."""

from typing import Final

from tasks.slicing.scheme import SlicingScheme

SCHEME: Final = SlicingScheme(
    "F",
    "both ends, mean of the contour's vertices",
    ends_only=True,
    contour="vertex_mean",
    axis="two_points",
)
