"""Scans of a scene: rays, hits, and the errors of a real instrument."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.conventions import azimuth_deg
from tasks.simulation.mesh import Surface
from tasks.simulation.raycasting import RayScene
from tasks.simulation.scanner import Scanner, ShotGrid, Window, shot_grid, unit_vectors
from tasks.simulation.shape import ShaftShape
from tasks.simulation.station import Setup

_PROBE_SHOTS: Final = 6000
"""Shots that tell which part of a window returns anything, before the step is chosen."""

_NEAREST_STRAY_M: Final = 2.0


@dataclass(frozen=True, slots=True)
class SimulatedScan:
    """A scan: ``points_m`` (n, 3) in the scanner's true frame, and ``surface`` (n,), a :class:`Surface` code each."""

    points_m: NDArray[np.float64]
    surface: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class _Shots:
    """What a window returned: angles and range of each return, and what it was."""

    azimuth_rad: NDArray[np.float64]
    elevation_rad: NDArray[np.float64]
    range_m: NDArray[np.float64]
    surface: NDArray[np.int64]


def scan_windows(setup: Setup, shape: ShaftShape) -> tuple[Window, ...]:
    """Fine on the structure, coarser along the horizon, coarsest all around: as crews scan an object."""
    margin_m = setup.margin_m
    middle_m = shape.axis_at(np.array([0.0, shape.height_m])).mean(axis=0)
    off_m = middle_m - setup.position_m[:2]
    distance_m = float(np.hypot(*off_m))
    spread_m = np.ptp(shape.axis_at(np.linspace(0.0, shape.height_m, 12)), axis=0).max()
    reach_m = max(shape.radius_foot_m, shape.radius_top_m) + 0.5 * float(spread_m) + margin_m
    top_m = shape.height_m + margin_m - float(setup.position_m[2])
    azimuth_rad = float(np.radians(azimuth_deg(float(off_m[0]), float(off_m[1])))) - setup.heading_rad
    return (
        Window(
            azimuth_rad,
            float(np.arctan2(reach_m, distance_m)),
            float(np.arctan2(-margin_m, distance_m)),
            float(np.arctan2(top_m, distance_m)),
            0.6,
        ),
        Window(0.0, np.pi, float(np.radians(-1.0)), float(np.radians(4.0)), 0.3),
        Window(0.0, np.pi, float(np.radians(-25.0)), float(np.radians(20.0)), 0.1),
    )


def simulate_station(
    scene: RayScene,
    setup: Setup,
    windows: Sequence[Window],
    scanner: Scanner,
    n_points: int,
    rng: np.random.Generator,
) -> SimulatedScan:
    """Scan a scene from one set-up, about ``n_points`` points.

    The true pose and level of ``setup`` are in the points; the noise of ``scanner`` is added to range and angles.
    The same generator state and scanner noise draw the same shots, whatever the sizes of the sigmas.

    Parameters
    ----------
    scene : RayScene
        What there is to hit, site frame.
    setup : Setup
        Where the scanner truly stands.
    windows : sequence of Window
        Parts of the sphere; their shares are normalised.
    scanner : Scanner
        Sigmas and rates of its errors.
    n_points : int
        Wanted number of points; the count comes out within some per cent.
    rng : Generator
        Source of everything that is random.

    Raises
    ------
    ShapeError
        If no point or no window is asked for, or the shares are not positive.
    """
    total = sum(window.share for window in windows)
    if n_points < 1 or not windows or total <= 0.0:
        raise ShapeError(
            f"simulate_station needs n_points >= 1 and windows with shares; got {n_points} and {len(windows)} "
            f"windows of {total} in all"
        )
    parts = []
    for window in windows:
        n_window = n_points * window.share / total
        grid = _fit_grid(scene, setup, window, n_window, rng)
        parts.append(_shoot(scene, setup, grid, scanner, rng))
    return SimulatedScan(
        np.vstack([_noisy_points(part, scanner, rng) for part in parts]),
        np.concatenate([part.surface for part in parts]),
    )


def _fit_grid(
    scene: RayScene, setup: Setup, window: Window, n_points: float, rng: np.random.Generator
) -> ShotGrid:
    """A grid of which about ``n_points`` shots return: a coarse look first tells the share that does."""
    probe = shot_grid(window, min(_PROBE_SHOTS, 8.0 * n_points), float(rng.uniform()))
    hits = scene.cast(setup.position_m, probe.directions() @ setup.rotation_site_scanner.T)
    share = max(float(np.mean(np.isfinite(hits.range_m))), 0.02)
    return shot_grid(window, n_points / share, float(rng.uniform()))


def _shoot(
    scene: RayScene, setup: Setup, grid: ShotGrid, scanner: Scanner, rng: np.random.Generator
) -> _Shots:
    shape = grid.elevation_rad.shape
    hits = scene.cast(setup.position_m, grid.directions() @ setup.rotation_site_scanner.T)
    range_m = np.where(hits.range_m <= scanner.reach_m, hits.range_m, np.inf).reshape(shape)
    mixed_m, is_mixed = _mix(range_m, hits.surface.reshape(shape), scanner, rng)
    is_stray = rng.uniform(size=shape) < scanner.stray_share
    stray_m = rng.uniform(_NEAREST_STRAY_M, scanner.reach_m, shape)
    found_m = np.where(is_stray, stray_m, mixed_m)
    surface = np.where(is_mixed, int(Surface.MIXED), hits.surface.reshape(shape))
    surface = np.where(is_stray, int(Surface.STRAY), surface)
    back = np.isfinite(found_m)
    return _Shots(grid.azimuth_rad[back], grid.elevation_rad[back], found_m[back], surface[back])


def _mix(
    range_m: NDArray[np.float64], surface: NDArray[np.int64], scanner: Scanner, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Let some shots beside another surface return a range between the two; grids (n_columns, n_shots).

    The neighbour is the next shot of the column or the same one of the next column, by chance.
    """
    along = rng.uniform(size=range_m.shape) < 0.5
    lucky = rng.uniform(size=range_m.shape) < scanner.mixed_probability
    weight = rng.uniform(size=range_m.shape)
    beside_m = np.where(along, np.roll(range_m, -1, axis=1), np.roll(range_m, -1, axis=0))
    beside = np.where(along, np.roll(surface, -1, axis=1), np.roll(surface, -1, axis=0))
    mixed = lucky & (surface != beside) & np.isfinite(range_m) & np.isfinite(beside_m)
    # the grid's last row and column have no next one
    mixed[:, -1] &= ~along[:, -1]
    mixed[-1, :] &= along[-1, :]
    between_m = range_m[mixed] + weight[mixed] * (beside_m[mixed] - range_m[mixed])
    out_m = range_m.copy()
    out_m[mixed] = between_m
    return out_m, mixed


def _noisy_points(shots: _Shots, scanner: Scanner, rng: np.random.Generator) -> NDArray[np.float64]:
    noise = rng.normal(size=(3, len(shots.range_m)))
    angle_rad = np.radians(scanner.angle_sigma_deg)
    range_m = shots.range_m + scanner.range_sigma_at(shots.range_m) * noise[0]
    directions = unit_vectors(
        shots.azimuth_rad + angle_rad * noise[1], shots.elevation_rad + angle_rad * noise[2]
    )
    return np.ascontiguousarray(range_m[:, None] * directions)
