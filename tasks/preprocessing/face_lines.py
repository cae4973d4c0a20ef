"""Planes of one direction that many height bands see: straight lines in distance and height."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.faces import normals_of
from tasks.preprocessing.kinds import StructureKind
from tasks.preprocessing.prior import StructurePrior

LINES: Final = 6
"""Planes kept a direction: two faces, and what stands beside them."""

FACE_SHARE: Final = 0.04
"""Share of a band's points on a plane that counts as a face there: a face has 0.25, a strip across one a tenth of that."""

TAPER_SLACK: Final = 0.03
"""How much steeper than the prior's taper a face may be, on top of its lean."""

APART_TOLERANCES: Final = 4.0
"""Planes nearer than this at both ends are one."""


@dataclass(frozen=True, slots=True)
class BandPoints:
    """Points of several height bands: (n, 2) about the prior's position, heights (n,), band (n,) from 0."""

    xy_m: NDArray[np.float64]
    z_m: NDArray[np.float64]
    band: NDArray[np.intp]
    n_bands: int


@dataclass(frozen=True, slots=True)
class FaceLines:
    """Distances (k, 2) of planes from the prior's position at the two ends of the shaft, metres, the best first."""

    at_ends_m: NDArray[np.float64]


def find_lines(
    seen: BandPoints,
    azimuth_rad: float,
    prior: StructurePrior,
    kind: StructureKind,
    tolerance_m: float,
) -> FaceLines:
    """Find the planes with a normal of this azimuth that the most bands have points on.

    Every slope within lean and taper is tried; a band votes for a strip by the share of its points there, and no more
    than once, so that a dense patch counts no more than a sparse whole.
    """
    across = seen.xy_m @ normals_of(np.array(azimuth_rad))
    low_m, high_m = prior.shaft_z_m
    up = seen.z_m - (low_m + high_m) / 2.0
    tall_m = high_m - low_m
    steepest = kind.max_lean + abs(prior.radius_m[1] - prior.radius_m[0]) / tall_m + TAPER_SLACK
    slopes = np.arange(-steepest, steepest, tolerance_m / tall_m * 2.0)
    reach = float(np.abs(across).max()) + steepest * tall_m
    n_strips = int(np.ceil(2.0 * reach / tolerance_m)) + 2
    per_band = np.bincount(seen.band, minlength=seen.n_bands)[:, None]
    votes = np.empty((len(slopes), n_strips - 1))
    for i, slope in enumerate(slopes):
        strip = ((across - slope * up + reach) / tolerance_m).astype(np.intp)
        counts = np.bincount(seen.band * n_strips + strip, minlength=seen.n_bands * n_strips)
        counts = counts.reshape(seen.n_bands, n_strips)
        # two strips together: a plane on the edge of two is then seen whole
        pairs = counts[:, 1:] + counts[:, :-1]
        votes[i] = np.minimum(pairs / (FACE_SHARE * per_band), 1.0).sum(axis=0)
    middle = np.asarray((np.arange(n_strips - 1) + 1.0) * tolerance_m - reach, dtype=np.float64)
    half_rise = np.asarray(slopes * tall_m / 2.0, dtype=np.float64)
    return _best(votes, middle, half_rise, APART_TOLERANCES * tolerance_m)


def _best(
    votes: NDArray[np.float64],
    middle_m: NDArray[np.float64],
    half_rise_m: NDArray[np.float64],
    apart_m: float,
) -> FaceLines:
    """Take the planes with the most votes (slopes, strips) that are apart at one end at least."""
    slope, strip = np.unravel_index(np.argsort(-votes, axis=None, kind="stable"), votes.shape)
    at_ends = np.column_stack([middle_m[strip] - half_rise_m[slope], middle_m[strip] + half_rise_m[slope]])
    chosen: list[NDArray[np.float64]] = []
    free = np.ones(len(at_ends), dtype=np.bool_)
    while len(chosen) < LINES and free.any():
        line = at_ends[int(np.argmax(free))]
        chosen.append(line)
        free &= np.abs(at_ends - line).max(axis=1) > apart_m
    return FaceLines(np.array(chosen))
