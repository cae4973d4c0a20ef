"""What a wall is off its round and even form: an oval, and a smooth random surface that differs from trial to trial."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from benchmarks.accuracy.sliced_shaft import BASE_RADIUS_M, HEIGHT_M, TAPER

WAVES: Final = 256
COLUMNS: Final = 120
ROWS: Final = 201


@dataclass(frozen=True, slots=True)
class Form:
    """Standard deviation of the roughness, the distance at which its correlation is exp(-1/2), amplitude of the oval."""

    rough_m: float
    correlation_m: float
    oval_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """Roughness on a grid (``ROWS``, ``COLUMNS``) of height and angle, metres, and an oval of that amplitude."""

    rough_m: NDArray[np.float64] | None
    oval_m: float
    oval_rad: float

    def off_m(self, angle_rad: NDArray[np.float64], z_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far outside the even cone the wall is at angles and heights (n,), metres."""
        off = self.oval_m * np.cos(2.0 * (angle_rad - self.oval_rad))
        if self.rough_m is None:
            return np.asarray(off)
        row = z_m / HEIGHT_M * (ROWS - 1)
        column = np.mod(angle_rad / (2.0 * np.pi), 1.0) * COLUMNS
        return np.asarray(off + map_coordinates(self.rough_m, [row, column], order=1, mode="grid-wrap"))


def draw_wall(form: Form, rng: np.random.Generator) -> Wall:
    """Draw a wall of that form."""
    oval_rad = float(rng.uniform(0.0, np.pi))
    if form.rough_m == 0.0:
        return Wall(None, form.oval_m, oval_rad)
    z = np.linspace(0.0, HEIGHT_M, ROWS)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, COLUMNS, endpoint=False)[None, :]
    radius = BASE_RADIUS_M + TAPER * z
    place = np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), np.broadcast_to(z, (ROWS, COLUMNS))], axis=-1
    )
    # a random field in space with a Gaussian correlation, cut by the wall: smooth all the way round
    waves = rng.normal(0.0, 1.0 / form.correlation_m, (3, WAVES))
    phases = rng.uniform(0.0, 2.0 * np.pi, WAVES)
    field = np.cos(place @ waves + phases).sum(axis=-1)
    return Wall(form.rough_m * np.sqrt(2.0 / WAVES) * field, form.oval_m, oval_rad)
