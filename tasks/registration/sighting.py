"""Find the structure in a single scan, in the frame of its scanner: it tells where the scanner looked."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.robust import mad_sigma, tukey_weights
from tasks.registration.planar import ScanPlanes
from tasks.registration.station import ShaftHint

UPRIGHT: Final = 0.5
"""Largest share of up in the normal of a wall."""

LEVELS: Final = 16
"""The shaft's height is divided into so many; a tree or a house fills the lowest only."""

LEAST_LEVELS: Final = 8
NEIGHBOUR_CELLS: Final = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
HEIGHT_SLACK_M: Final = 5.0
"""How far the scanner's own height may be from the foot of the structure."""

MOST_CANDIDATES: Final = 6
LEAST_POINTS: Final = 60
REWEIGHTINGS: Final = 12
WORST_FIT: Final = 0.06
"""Largest robust scale of the residuals, as a share of the radius: a house corner does worse."""

LEAST_INLIERS: Final = 0.5
RADIUS_SHARE: Final = 0.3
"""Standard deviation of a rough radius, as a share of it."""

FACING: Final = 0.7
"""The points of a half shaft lie on average that share of the radius in front of its axis."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """Where a scan sees the shaft: its axis at mid height (2,), scanner frame, metres, and how many points say so.

    ``radius_scale`` is how many times as wide it is as the hint says.
    """

    centre_m: NDArray[np.float64]
    radius_scale: float
    n_points: int

    @property
    def distance_m(self) -> float:
        """Horizontal distance from scanner to axis."""
        return float(np.hypot(*self.centre_m))

    @property
    def azimuth_rad(self) -> float:
        """Direction in the scanner frame, clockwise from its +y axis."""
        return float(np.arctan2(self.centre_m[0], self.centre_m[1]))


def walls(planes: ScanPlanes) -> NDArray[np.float64]:
    """Points (m, 3) of upright surfaces."""
    return planes.fine.points_m[np.abs(planes.fine.normals[:, 2]) < UPRIGHT]


def sight_shaft(walls_m: NDArray[np.float64], hint: ShaftHint) -> tuple[Sighting, ...]:
    """Everything in a scan that could be the shaft, most points first.

    Parameters
    ----------
    walls_m : (m, 3) array
        Points of upright surfaces, scanner frame, metres.
    hint : ShaftHint
        Height and radius; where it stands is not used.
    """
    low, high = hint.shaft_z_m
    tall = walls_m[(walls_m[:, 2] > low - HEIGHT_SLACK_M) & (walls_m[:, 2] < high + HEIGHT_SLACK_M)]
    if len(tall) < LEAST_POINTS:
        return ()
    fits = [_fit(tall, place, hint) for place in _tall_places(tall, hint)]
    found = [sighting for sighting in fits if sighting is not None]
    return tuple(sorted(_distinct(found, max(hint.radius_m)), key=lambda one: -one.n_points))


def _cell_m(hint: ShaftHint) -> float:
    return max(1.0, 0.5 * max(hint.radius_m))


def _tall_places(tall_m: NDArray[np.float64], hint: ShaftHint) -> list[NDArray[np.float64]]:
    """Places (2,) around which most levels of the shaft's height are filled, the best first."""
    low, high = hint.shaft_z_m
    cell_m = _cell_m(hint)
    level = np.clip((tall_m[:, 2] - low) / (high - low) * LEVELS, 0, LEVELS - 1).astype(np.int64)
    cells = np.floor(tall_m[:, :2] / cell_m).astype(np.int64)
    filled = np.unique(np.column_stack([cells, level]), axis=0)
    # a shaft tapers and leans out of one cell: its neighbours count, too
    around = (filled[:, None, :2] + NEIGHBOUR_CELLS).reshape(-1, 2)
    spread = np.unique(np.column_stack([around, np.repeat(filled[:, 2], len(NEIGHBOUR_CELLS))]), axis=0)
    places, counts = np.unique(spread[:, :2], axis=0, return_counts=True)
    best = [i for i in np.argsort(-counts, kind="stable") if counts[i] >= LEAST_LEVELS]
    chosen: list[NDArray[np.float64]] = []
    for i in best:
        place = (places[i] + 0.5) * cell_m
        if all(np.hypot(*(place - other)) > 2.0 * max(hint.radius_m) for other in chosen):
            chosen.append(place)
        if len(chosen) == MOST_CANDIDATES:
            break
    return chosen


def _fit(tall_m: NDArray[np.float64], place_m: NDArray[np.float64], hint: ShaftHint) -> Sighting | None:
    """Fit a leaning shaft of roughly the hinted radius to what stands around a place."""
    reach_m = max(hint.radius_m) + 2.0 * _cell_m(hint)
    near = tall_m[np.hypot(*(tall_m[:, :2] - place_m).T) < reach_m]
    if len(near) < LEAST_POINTS:
        return None
    middle = near[:, :2].mean(axis=0)
    low, high = hint.shaft_z_m
    height = near[:, 2] - (low + high) / 2.0
    radius = np.interp(near[:, 2], hint.shaft_z_m, hint.radius_m)
    # east, north, lean east, lean north, and how many times the hinted radius
    shaft = np.r_[middle * (1.0 + FACING * radius.mean() / np.hypot(*middle)), 0.0, 0.0, 1.0]
    sigma = reach_m
    for _ in range(REWEIGHTINGS):
        away = near[:, :2] - shaft[:2] - height[:, None] * shaft[2:4]
        distance = np.hypot(*away.T)
        residual = distance - shaft[4] * radius
        outward = away / distance[:, None]
        weight = tukey_weights(residual, sigma)
        design = np.hstack([outward, outward * height[:, None], radius[:, None]])
        held = np.array([1e-9, 1e-9, 1e-9, 1e-9, (sigma / RADIUS_SHARE) ** 2])
        right = design.T @ (weight * residual) + held * np.array([0.0, 0.0, 0.0, 0.0, 1.0 - shaft[4]])
        shaft = shaft + np.linalg.solve(design.T @ (design * weight[:, None]) + np.diag(held), right)
        sigma = max(mad_sigma(residual), 0.02)
    inliers = int(np.count_nonzero(np.abs(residual) < 4.0 * sigma))
    is_round = sigma < WORST_FIT * float(radius.mean()) and inliers > LEAST_INLIERS * len(near)
    is_as_wide = abs(shaft[4] - 1.0) < 2.0 * RADIUS_SHARE
    return Sighting(shaft[:2], float(shaft[4]), inliers) if is_round and is_as_wide else None


def _distinct(found: list[Sighting], apart_m: float) -> list[Sighting]:
    kept: list[Sighting] = []
    for one in found:
        if all(np.hypot(*(one.centre_m - other.centre_m)) > apart_m for other in kept):
            kept.append(one)
    return kept
