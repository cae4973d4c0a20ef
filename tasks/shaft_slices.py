"""Which points of a shaft belong to which slice, under every scheme: at fixed heights, or following the points."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.methods import Method, weighs_sights
from tasks.preprocessing import ShaftModel
from tasks.slicing import (
    AdaptiveCut,
    RingPoints,
    Rows,
    SlicingScheme,
    ThicknessLimit,
    adaptive_slices,
    linear_limit,
    rows_between_edges,
    rows_of_slices,
    slice_heights,
)

CHUNK: Final = 65_536
"""Points that are worked on at once: what is made of them on the way stays in the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class ShaftCloud:
    """The points (n, 3) of a shaft, site frame, metres, its rough model, and the sigma (n,) of every point or None.

    ``sigma_m`` is what instrument and line of sight give across the surface, metres; None where the stations of the
    points are not known or nothing needs it.
    """

    points_m: NDArray[np.float64]
    model: ShaftModel
    sigma_m: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Slice:
    """A slice: mid-height and thickness in metres, and which points are its own."""

    z_m: float
    thickness_m: float
    rows: Rows


def slice_cloud(
    cloud: ShaftCloud, scheme: SlicingScheme, method: Method, shaft_z_m: tuple[float, float]
) -> list[Slice]:
    """Cut a shaft by a scheme, from the bottom up.

    Slices at fixed heights are as thick as the method wants; those that follow the points have their own thickness.
    """
    if scheme.adaptive is not None:
        return _following(cloud, scheme.adaptive, method, shaft_z_m)
    heights_m = slice_heights(scheme, shaft_z_m)
    cut = rows_of_slices(cloud.points_m[:, 2], heights_m, method.thickness_m)
    return [Slice(float(z), method.thickness_m, rows) for z, rows in zip(heights_m, cut, strict=True)]


def _following(
    cloud: ShaftCloud, cut: AdaptiveCut, method: Method, shaft_z_m: tuple[float, float]
) -> list[Slice]:
    limit = _thickness_limit(cloud.model, cut)
    edges_m = adaptive_slices(_ring_points(cloud, method), cut, shaft_z_m, limit).edges_m
    middles_m, thickness_m = (edges_m[1:] + edges_m[:-1]) / 2, np.diff(edges_m)
    rows = rows_between_edges(cloud.points_m[:, 2], edges_m)
    return [
        Slice(float(z), float(h), points_of)
        for z, h, points_of in zip(middles_m, thickness_m, rows, strict=True)
    ]


def _ring_points(cloud: ShaftCloud, method: Method) -> Iterator[RingPoints]:
    """The points as a circle sees them, in chunks, with standard deviations as they scatter.

    What instrument and line of sight give says how they differ; how large they are is what was measured of the shaft.
    """
    measured_m, known_m = cloud.model.noise_sigma_m, cloud.sigma_m
    usual_m = 1.0 if known_m is None else float(np.median(known_m))
    for start in range(0, len(cloud.points_m), CHUNK):
        rows = slice(start, start + CHUNK)
        points_m = cloud.points_m[rows]
        out = points_m[:, :2] - cloud.model.axis_at(points_m[:, 2])
        sigma_m = (
            np.full(len(points_m), measured_m) if known_m is None else known_m[rows] * (measured_m / usual_m)
        )
        yield RingPoints(
            z_m=points_m[:, 2],
            azimuth_rad=np.arctan2(out[:, 0], out[:, 1]),
            sigma_m=sigma_m,
            weights=sigma_m**-2.0 if weighs_sights(method) else None,
        )


def _thickness_limit(model: ShaftModel, cut: AdaptiveCut) -> ThicknessLimit:
    form_m = np.array([model.bend_east_m, model.bend_north_m, model.radius_m])
    return linear_limit(np.array(model.radius_z_m), form_m, cut.sigma_center_m)
