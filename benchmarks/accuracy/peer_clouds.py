"""The clouds that packages are compared on: a whole cone, or an arc of it, with or without a ladder."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.sliced_shaft import LADDER_RAD, LEAN, OFF_M

HEIGHT_M: Final = 100.0
RADII_M: Final = (5.0, 3.0)
SIGMA_M: Final = 0.015
LADDER_SHARE: Final = 0.1
SLICES: Final = 100
THICKNESS_M: Final = 0.05


@dataclass(frozen=True, slots=True)
class CloudCase:
    """What is seen, in degrees of the circumference, and whether a ladder is on it."""

    arc_deg: float
    ladder: bool


CASES: Final[Mapping[str, CloudCase]] = {
    "full ring": CloudCase(360.0, ladder=False),
    "+ ladder": CloudCase(360.0, ladder=True),
    "120 deg arc": CloudCase(120.0, ladder=False),
    "arc + ladder": CloudCase(120.0, ladder=True),
}


@dataclass(frozen=True, slots=True, eq=False)
class Slice:
    """Points (n, 3) of a band and its mid-height, metres."""

    points_m: NDArray[np.float64]
    z_m: float


def draw_cloud(case: CloudCase, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Points (n, 3), white and radial noise."""
    half = np.radians(case.arc_deg) / 2.0
    z = rng.uniform(0.0, HEIGHT_M, n)
    angle = rng.uniform(-half, half, n)
    off = rng.normal(0.0, SIGMA_M, n)
    if case.ladder:
        on = rng.random(n) < LADDER_SHARE
        angle[on] = half / 4.0 + LADDER_RAD * rng.uniform(-0.5, 0.5, int(on.sum()))
        off[on] = rng.uniform(*OFF_M, int(on.sum()))
    radius = RADII_M[0] + (RADII_M[1] - RADII_M[0]) * z / HEIGHT_M + off
    return np.column_stack([LEAN[0] * z + radius * np.cos(angle), LEAN[1] * z + radius * np.sin(angle), z])


def cut(points_m: NDArray[np.float64]) -> Iterator[Slice]:
    """Bands of the cloud, the same for everyone who works on slices."""
    spacing = HEIGHT_M / SLICES
    number = np.floor(points_m[:, 2] / spacing).astype(np.intp)
    middle = (number + 0.5) * spacing
    inside = np.flatnonzero(np.abs(points_m[:, 2] - middle) <= THICKNESS_M / 2.0)
    order = inside[np.argsort(number[inside], kind="stable")]
    ends = np.searchsorted(number[order], np.arange(SLICES + 1))
    for k in range(SLICES):
        yield Slice(points_m[order[ends[k] : ends[k + 1]]], float((k + 0.5) * spacing))
