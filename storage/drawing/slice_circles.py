"""The slices of an epoch as circles at their heights, as ellipses too where they were found oval."""

from collections.abc import Iterator, Mapping
from typing import Final

from storage.drawing.content import Circle, DrawingFrame, Ellipse, Feature, Point, Value
from storage.records import SliceRow

OF_A_SLICE: Final = (
    "scheme",
    "method",
    "slice_index",
    "z_m",
    "thickness_m",
    "n_points",
    "n_points_fit",
    "radius_m",
    "sigma_center_m",
    "rmse_m",
    "noise_m",
    "arc_coverage_deg",
    "weight",
    "residual_m",
    "offset_east_m",
    "offset_north_m",
    "radius_offset_m",
    "roundness_m",
    "ovality_m",
    "ovality_azimuth_deg",
    "contour",
    "contour_reason",
)

STRAIGHT_SIDED: Final = frozenset({"polygon"})
"""Contours whose radius is half of a side: a circle would not be what was measured."""


def slice_features(row: SliceRow, frame: DrawingFrame) -> Iterator[Feature]:
    """Draw a slice: its circle or, of a section with straight sides, its centre; nothing where it has no centre.

    The ellipse has the mean radius plus and minus the amplitude of the second harmonic of the radius.
    """
    if row.center_east_m is None or row.center_north_m is None:
        return
    center = frame.placed(row.center_east_m, row.center_north_m, row.z_m)
    known = _attributes(row)
    label = f"{row.scheme}/{row.method} {row.z_m:.2f} m"
    if row.radius_m is None or row.contour in STRAIGHT_SIDED:
        yield Feature("centre", Point(center), known, label)
        return
    yield Feature("circle", Circle(center, row.radius_m), known, label)
    if row.ovality_m is not None and row.ovality_azimuth_deg is not None:
        larger, smaller = row.radius_m + row.ovality_m, row.radius_m - row.ovality_m
        yield Feature("ellipse", Ellipse(center, larger, smaller, row.ovality_azimuth_deg), known)


def _attributes(row: SliceRow) -> Mapping[str, Value]:
    return {name: getattr(row, name) for name in OF_A_SLICE}
