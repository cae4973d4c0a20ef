"""A leaning, tapering shaft of 100 m as 101 thin slices, with white radial noise and points that are not on it."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from tasks.contours import Section

Attached = Literal["nothing", "ladder", "platform"]

LEAN: Final = np.array([0.006, 0.008])
"""East and north over up: 10 permille, as the paper's chimney."""

TAPER: Final = -0.02
BASE_RADIUS_M: Final = 4.5
HEIGHT_M: Final = 100.0
SLICES: Final = 101
THICKNESS_M: Final = 0.01
"""Thin enough that those who do not straighten a slice lose nothing by it."""

BISECTOR_RAD: Final = float(np.radians(30.0))
LADDER_RAD: Final = float(np.radians(30.0))
OFF_M: Final = (0.2, 1.2)
"""How far outside the shell the attached points lie, metres."""

EVERY_PLATFORM: Final = 3
"""A platform is in every third slice, with three times the share there."""


@dataclass(frozen=True, slots=True)
class Case:
    """What is seen of the shaft: an arc, in degrees, with noise, and a share of the points on what is attached to it."""

    arc_deg: float
    sigma_m: float
    attached: Attached = "nothing"
    share: float = 0.1
    points: int = 200


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """One trial: points (m, n, 3), their angles and radial errors (m, n), and which of them lie on the shaft."""

    z_m: NDArray[np.float64]
    points_m: NDArray[np.float64]
    angle_rad: NDArray[np.float64]
    error_m: NDArray[np.float64]
    clean: NDArray[np.bool_]
    sigma_m: float

    def sections(self) -> list[Section]:
        """The slices as contour models get them, with the rough shape of the shaft."""
        sigma = np.full(self.points_m.shape[1], self.sigma_m)
        return [
            Section(points, float(z), THICKNESS_M, TAPER, float(LEAN[0]), float(LEAN[1]), sigma_m=sigma)
            for points, z in zip(self.points_m, self.z_m, strict=True)
        ]


def draw(case: Case, rng: np.random.Generator) -> Drawn:
    """Draw a trial; horizontal sections are round, and the lean is exact."""
    z_m = np.linspace(0.0, HEIGHT_M, SLICES)
    shape = (SLICES, case.points)
    half = np.radians(case.arc_deg) / 2.0
    angle = BISECTOR_RAD + rng.uniform(-half, half, shape)
    error = rng.normal(0.0, case.sigma_m, shape)
    height = z_m[:, None] + THICKNESS_M * rng.uniform(-0.5, 0.5, shape)
    clean = _clean(case, shape, rng)
    off = np.where(clean, error, rng.uniform(*OFF_M, shape))
    if case.attached == "ladder":
        on_ladder = BISECTOR_RAD + half / 4.0 + LADDER_RAD * rng.uniform(-0.5, 0.5, shape)
        angle = np.where(clean, angle, on_ladder)
    radius = BASE_RADIUS_M + TAPER * height + off
    points = np.stack(
        [
            LEAN[0] * height + radius * np.cos(angle),
            LEAN[1] * height + radius * np.sin(angle),
            height,
        ],
        axis=-1,
    )
    return Drawn(z_m, points, angle, error, clean, case.sigma_m)


def _clean(case: Case, shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.bool_]:
    if case.attached == "nothing":
        return np.ones(shape, dtype=np.bool_)
    if case.attached == "ladder":
        return rng.random(shape) >= case.share
    here = np.arange(shape[0]) % EVERY_PLATFORM == 0
    return np.asarray((rng.random(shape) >= EVERY_PLATFORM * case.share) | ~here[:, None])
