"""Faces of a section of which nothing is known but that there are four at right angles."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.contours.outline import Outline
from tasks.geometry.faces import normals_of
from tasks.geometry.failure import FitFailure
from tasks.geometry.orientation import edge_directions

SIDES: Final = 4

STRIP: Final = 0.02
"""Width of the strips in which points of a face gather, as a part of the extent of the section."""

GATHERED: Final = 0.06
"""Share of the points in one strip, or two neighbours, that makes it a face: one across a face holds a third of that."""

ONE_FACE: Final = 0.2
"""Faces nearer to each other than this part of the extent are one: a face and what hangs on it."""


def rough_outline(xy_m: NDArray[np.float64], taper: float) -> Outline | FitFailure:
    """Find four faces at right angles among the points (n, 2) of a section, about the middle of the box they make.

    The outermost strips with many points are the faces; where only one of two opposite faces has points, the other is
    put where the points end.
    """
    extent = float(np.ptp(xy_m, axis=0).max())
    azimuth = float(edge_directions(xy_m, np.zeros(len(xy_m), dtype=np.intp), SIDES, STRIP * extent, 1)[0])
    azimuths = azimuth + np.arange(SIDES) * np.pi / 2
    ends = [_ends(xy_m @ normals_of(np.array(a)), extent) for a in azimuths[:2]]
    if any(low >= high for low, high in ends):
        return FitFailure("needs points that gather along straight faces, got none that do")
    middle = np.array([(low + high) / 2.0 for low, high in ends])
    half = np.array([(high - low) / 2.0 for low, high in ends])
    return Outline(
        center_m=middle @ normals_of(azimuths[:2]),
        azimuth_rad=azimuths,
        half_m=np.tile(half, 2),
        taper=np.full(SIDES, taper),
        sigma_m=np.full(SIDES, np.inf),
    )


def _ends(across_m: NDArray[np.float64], extent_m: float) -> tuple[float, float]:
    """Places of the two faces, metres; (0, 0) where no points gather."""
    low, width = float(across_m.min()), STRIP * extent_m
    strip = ((across_m - low) / width).astype(np.intp)
    counts = np.bincount(strip, minlength=int(strip.max()) + 2)
    dense = np.flatnonzero(counts[1:] + counts[:-1] >= GATHERED * len(across_m))
    if not len(dense):
        return 0.0, 0.0
    first, last = low + width * (dense[0] + 1.0), low + width * (dense[-1] + 1.0)
    if last - first >= ONE_FACE * extent_m:
        return first, last
    # one face: the rest of the points says on which side the section lies
    face = (first + last) / 2.0
    far = max(float(across_m.max()) - face, face - low)
    return (face, face + far) if float(across_m.mean()) > face else (face - far, face)
