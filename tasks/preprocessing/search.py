"""The search for the shaft: circles in height bands, linked."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.preprocessing.bands import sample_bands
from tasks.preprocessing.consensus import CircleSearch, find_circles
from tasks.preprocessing.kinds import StructureKind
from tasks.preprocessing.linking import BandCircles, RoughShaft, link_bands
from tasks.preprocessing.prior import StructurePrior

POINTS_PER_BAND: Final = 800
"""Points of a band that vote: enough to see a tenth of a circumference, few enough for 40 bands in a blink."""

POINTS_PER_BAND_MIN: Final = 12
"""A band with fewer has nothing to vote on."""

TOLERANCE_FLOOR_M: Final = 0.01
TOLERANCE_RADII: Final = 0.02
"""Half width of the ring that counts as on a circle: noise, and lean, taper and ovality within a band."""

SCORE_MIN: Final = 0.12
"""Circles with less of their circumference in evidence are not linked: 0.12 is about 45 degrees."""


def reach_m(prior: StructurePrior, kind: StructureKind) -> float:
    """Horizontal distance from the prior's position that the shaft can reach, lean included; metres."""
    tall_m = prior.shaft_z_m[1] - min(prior.shaft_z_m[0], 0.0)
    # a corner is farther out than the middle of its face
    corner = 1.0 / np.cos(np.pi / kind.n_faces) if kind.n_faces else 1.0
    return (
        float(corner) * kind.radius_window[1] * max(prior.radius_m)
        + kind.position_slack_m
        + kind.max_lean * tall_m
    )


def find_rough_shaft(
    points_m: NDArray[np.float64], prior: StructurePrior, kind: StructureKind, rng: np.random.Generator
) -> RoughShaft | FitFailure:
    """Find the shaft roughly among points (n, 3) of its heights and surroundings."""
    edges_m = prior.band_edges_m()
    middles_m = 0.5 * (edges_m[:-1] + edges_m[1:])
    radii_m = prior.radius_at(middles_m)
    bands: list[BandCircles] = []
    for index, rows in enumerate(sample_bands(points_m[:, 2], edges_m, POINTS_PER_BAND, rng)):
        if len(rows) >= POINTS_PER_BAND_MIN:
            found = find_circles(points_m[rows, :2], _search(float(radii_m[index]), kind), rng)
            good = found.scores >= SCORE_MIN
            n = int(good.sum())
            z_m = np.full(n, middles_m[index])
            bands.append(BandCircles(np.full(n, index), z_m, found.parameters_m[good], found.scores[good]))
    if sum(len(band.scores) for band in bands) < 2:
        return FitFailure(
            f"nothing round of radius {kind.radius_window[0] * min(prior.radius_m):.2f} to "
            f"{kind.radius_window[1] * max(prior.radius_m):.2f} m within {reach_m(prior, kind):.1f} m of "
            f"base_xy_m {prior.base_xy_m}"
        )
    return link_bands(_joined(bands), prior, kind, len(middles_m))


def _search(radius_m: float, kind: StructureKind) -> CircleSearch:
    lo, hi = kind.radius_window
    return CircleSearch((lo * radius_m, hi * radius_m), TOLERANCE_FLOOR_M + TOLERANCE_RADII * radius_m)


def _joined(bands: list[BandCircles]) -> BandCircles:
    return BandCircles(
        np.concatenate([band.band for band in bands]),
        np.concatenate([band.z_m for band in bands]),
        np.concatenate([band.parameters_m for band in bands]),
        np.concatenate([band.scores for band in bands]),
    )
