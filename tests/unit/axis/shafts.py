"""Centres along a leaning shaft for the tests of the axis estimators."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LEAN = np.array([0.007, -0.005])


@dataclass(frozen=True, slots=True, eq=False)
class Shaft:
    """Centres (m, 3) and stated covariances (m, 2, 2)."""

    centres_m: NDArray[np.float64]
    covariances_m2: NDArray[np.float64]


def shaft(
    rng: np.random.Generator,
    m: int = 101,
    sigma_m: float = 0.01,
    stated_m: float | None = None,
    bend_m: float = 0.0,
) -> Shaft:
    """A shaft of 100 m with a parabola of that amplitude about its line, to the east."""
    z = np.linspace(0.0, 100.0, m)
    x = z / 50.0 - 1.0
    bend = bend_m * (3 * x**2 - 1) / 2
    horizontal = z[:, None] * LEAN + sigma_m * rng.standard_normal((m, 2))
    horizontal[:, 0] += bend
    stated = sigma_m if stated_m is None else stated_m
    return Shaft(np.column_stack([horizontal, z]), np.tile(np.eye(2) * stated**2, (m, 1, 1)))


def push(rng: np.random.Generator, centres_m: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Centres of which a share lies 0.05 to 0.3 m aside."""
    pushed = centres_m.copy()
    hit = rng.choice(len(pushed), round(share * len(pushed)), replace=False)
    angle, away = rng.uniform(0, 2 * np.pi, len(hit)), rng.uniform(0.05, 0.3, len(hit))
    pushed[hit, 0] += away * np.cos(angle)
    pushed[hit, 1] += away * np.sin(angle)
    return pushed
