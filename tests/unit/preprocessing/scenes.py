"""Synthetic clouds of a chimney with known truth; not a test."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.preprocessing import Shaft, ShaftOptions, StructurePrior, isolate_shaft

ARCSEC: Final = 206264.806
"""Seconds of arc in a unit of lean."""

CHIMNEY: Final = StructurePrior("chimney", (2.0, 62.0), (0.0, 0.0), (3.0, 2.0))

LEAN: Final = np.array([0.010, -0.006])
"""True lean of every scene's shaft."""


@dataclass(frozen=True, slots=True)
class Oddity:
    """What is not straight, round or without noise about a shaft, in metres."""

    bend_m: float = 0.0
    oval_m: float = 0.0
    noise_m: float = 0.008


def shaft_cloud(
    rng: np.random.Generator, n: int = 20_000, oddity: Oddity | None = None
) -> NDArray[np.float64]:
    """Points (n, 3) of a leaning, tapered shaft from 1 to 63 m, all around."""
    odd = Oddity() if oddity is None else oddity
    z, angle = rng.uniform(1.0, 63.0, n), rng.uniform(0.0, 2.0 * np.pi, n)
    radius = true_radius_m(z) + odd.oval_m * np.cos(2.0 * angle - 1.0) + rng.normal(0.0, odd.noise_m, n)
    east = LEAN[0] * z + odd.bend_m * (z / 62.0) ** 2 + radius * np.cos(angle)
    return np.column_stack([east, LEAN[1] * z + radius * np.sin(angle), z])


def true_radius_m(z_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radius of every scene's shaft, metres."""
    return np.asarray(3.0 - (z_m - 2.0) / 60.0)


def off_surface_m(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """True distance (n,) from a straight round shaft, positive outside, metres."""
    ray = points_m[:, :2] - np.outer(points_m[:, 2], LEAN)
    return np.asarray(np.hypot(ray[:, 0], ray[:, 1]) - true_radius_m(points_m[:, 2]))


def ladder_cloud(rng: np.random.Generator, n: int = 2_000) -> NDArray[np.float64]:
    """Points (n, 3) of a ladder 0.5 m wide on the north side, 0.25 m off the shaft."""
    z = rng.uniform(1.0, 63.0, n)
    north = LEAN[1] * z + true_radius_m(z) + 0.25 + rng.normal(0.0, 0.01, n)
    return np.column_stack([LEAN[0] * z + rng.choice([-0.25, 0.25], n), north, z])


def stray_cloud(rng: np.random.Generator, n: int) -> NDArray[np.float64]:
    """Points (n, 3) anywhere about the shaft, inside and outside."""
    return np.column_stack([rng.uniform(-6.0, 6.0, (n, 2)), rng.uniform(0.0, 66.0, n)])


def isolated(
    points_m: NDArray[np.float64], prior: StructurePrior = CHIMNEY, options: ShaftOptions | None = None
) -> Shaft:
    """Isolate, and say why if it failed."""
    shaft = isolate_shaft(points_m, prior, options)
    assert not isinstance(shaft, FitFailure), shaft
    return shaft


def lean_of(shaft: Shaft) -> NDArray[np.float64]:
    """Lean vector (2,) of the straight axis."""
    return np.array([shaft.model.lean_east, shaft.model.lean_north])


def counts_of(shaft: Shaft) -> dict[str, int]:
    """Points by reason."""
    return {removal.reason: removal.n_points for removal in shaft.removed}
