"""Find the surface of a shaft of any kind: a rough search, and a robust fit that starts from it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.preprocessing.bands import sample_bands
from tasks.preprocessing.face_search import find_rough_faces
from tasks.preprocessing.face_surface import (
    FaceSurface,
    distance_from_faces,
    fit_faces_surface,
    model_of_faces,
    unroll_faces,
)
from tasks.preprocessing.kinds import StructureKind
from tasks.preprocessing.model import ShaftModel
from tasks.preprocessing.prior import StructurePrior
from tasks.preprocessing.search import find_rough_shaft
from tasks.preprocessing.surface import TERMS, Surface, SurfaceDistance, distance_from, fit_surface, unroll

POINTS_PER_BAND_FIT: Final = 1500
"""Points of a band that fit the surface: 1500 leave a centre good to a thirtieth of the noise."""

START_GATE_RADII: Final = 0.15
"""Half width, in radii, of the first gate around the rough shaft: what its parabola may be off."""


@dataclass(frozen=True, slots=True)
class FoundSurface:
    """The model of a shaft, and how points (n, 3) are measured from its surface and laid out on it (n,), metres."""

    model: ShaftModel
    distance: Callable[[NDArray[np.float64]], SurfaceDistance]
    unroll: Callable[[NDArray[np.float64]], NDArray[np.float64]]


def find_surface(
    near_m: NDArray[np.float64], prior: StructurePrior, kind: StructureKind, seed: int
) -> FoundSurface | FitFailure:
    """Fit the surface that the kind of structure has to points (n, 3) of its heights and surroundings."""
    rng = np.random.default_rng(seed)
    if kind.n_faces:
        faces = _find_faces(near_m, prior, kind, rng)
        if isinstance(faces, FitFailure):
            return faces
        return FoundSurface(
            model_of_faces(faces), partial(distance_from_faces, faces), partial(unroll_faces, faces)
        )
    surface = _find_round(near_m, prior, kind, rng)
    if isinstance(surface, FitFailure):
        return surface
    return FoundSurface(_model(surface), partial(distance_from, surface), partial(unroll, surface))


def is_there(points_m: NDArray[np.float64], prior: StructurePrior, kind: StructureKind) -> bool:
    """Tell whether the rough search finds a shaft among points (n, 3)."""
    search = find_rough_faces if kind.n_faces else find_rough_shaft
    return not isinstance(search(points_m, prior, kind, np.random.default_rng(0)), FitFailure)


def _find_round(
    near_m: NDArray[np.float64], prior: StructurePrior, kind: StructureKind, rng: np.random.Generator
) -> Surface | FitFailure:
    rough = find_rough_shaft(near_m, prior, kind, rng)
    if isinstance(rough, FitFailure):
        return rough
    knots_m = prior.band_edges_m()
    values_m = np.zeros((len(knots_m), TERMS))
    values_m[:, :3] = rough.at(knots_m)
    if values_m[:, 2].min() <= 0.0:
        return FitFailure(
            f"needed positive radii over shaft_z_m {prior.shaft_z_m}, the round sections narrow to none"
        )
    start = Surface(knots_m, values_m, 0.0)
    gate_m = START_GATE_RADII * float(values_m[:, 2].mean())
    return fit_surface(start, _sample(near_m, knots_m, rng), gate_m)


def _find_faces(
    near_m: NDArray[np.float64], prior: StructurePrior, kind: StructureKind, rng: np.random.Generator
) -> FaceSurface | FitFailure:
    rough = find_rough_faces(near_m, prior, kind, rng)
    if isinstance(rough, FitFailure):
        return rough
    knots_m = prior.band_edges_m()
    k, m = len(knots_m), len(rough.azimuth_rad)
    start = FaceSurface(
        knots_z_m=knots_m,
        origin_m=np.array(prior.base_xy_m),
        azimuth_rad=rough.azimuth_rad,
        distance_m=rough.at(knots_m, prior.shaft_z_m),
        twist_rad_per_m=0.0,
        seen=np.zeros(m, dtype=np.bool_),
        variance_m2=np.zeros((m, k, k)),
        sigma_m=0.0,
    )
    gate_m = START_GATE_RADII * float(start.half_m.mean())
    return fit_faces_surface(start, _sample(near_m, knots_m, rng), gate_m)


def _sample(
    near_m: NDArray[np.float64], knots_m: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    return near_m[np.concatenate(sample_bands(near_m[:, 2], knots_m, POINTS_PER_BAND_FIT, rng))]


def _model(surface: Surface) -> ShaftModel:
    """Split the axis of the surface into the straight line, uniform over the height, and the bending about it."""
    z_m, axis_m = surface.knots_z_m, surface.values_m[:, :2]
    line = np.polyfit(z_m, axis_m, 1)
    bend_m = axis_m - z_m[:, None] * line[0] - line[1]
    return ShaftModel(
        base_east_m=float(line[1, 0]),
        base_north_m=float(line[1, 1]),
        lean_east=float(line[0, 0]),
        lean_north=float(line[0, 1]),
        radius_z_m=tuple(z_m.tolist()),
        radius_m=tuple(surface.values_m[:, 2].tolist()),
        bend_east_m=tuple(bend_m[:, 0].tolist()),
        bend_north_m=tuple(bend_m[:, 1].tolist()),
        noise_sigma_m=surface.sigma_m,
    )
