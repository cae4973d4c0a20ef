"""Shafts with known dents and bulges, seen from stations around, and their maps."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.records import SurfaceMapCell
from tasks.map_shapes import DesignedShape, StraightAxis
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.registration import Registration
from tasks.surface_map import MapQuestion, map_surface
from tasks.whole_surface import RoundCut, SurfaceLean, SurfaceQuestion, lean_of_surface
from tests.unit.networks import MODEL, SHAFT_Z_M, registration, sigmas

AZIMUTHS_DEG = tuple(45.0 * k for k in range(8))

Wall = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def smooth(z_m: NDArray[np.float64], azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """A wall without dents."""
    return np.zeros(np.broadcast(z_m, azimuth_deg).shape)


def bulge(z_m: NDArray[np.float64], azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """20 mm outward from 42 to 47 m, azimuth 100 to 130 degrees."""
    return 0.020 * ((z_m >= 42.0) & (z_m < 47.0) & (azimuth_deg >= 100.0) & (azimuth_deg < 130.0))


@dataclass(frozen=True)
class Scene:
    """Points of a shaft; ``half_view_deg`` of its circumference is seen on each side of a station."""

    wall: Wall = smooth
    points: int = 40_000
    sigma_m: float = 0.005
    azimuths_deg: tuple[float, ...] = AZIMUTHS_DEG
    half_view_deg: float = 80.0


def cloud_of(scene: Scene, seed: int = 1) -> PlacedCloud:
    """The points of ``MODEL`` with a wall and radial noise."""
    rng = np.random.default_rng(seed)
    station = rng.integers(0, len(scene.azimuths_deg), scene.points)
    z_m = rng.uniform(*SHAFT_Z_M, scene.points)
    view_deg = rng.uniform(-scene.half_view_deg, scene.half_view_deg, scene.points)
    azimuth_deg = (np.array(scene.azimuths_deg)[station] + view_deg) % 360.0
    radius_m = (
        MODEL.radius_at(z_m) + scene.wall(z_m, azimuth_deg) + scene.sigma_m * rng.normal(size=scene.points)
    )
    turn = np.radians(azimuth_deg)
    xy = MODEL.axis_at(z_m) + radius_m[:, None] * np.column_stack([np.sin(turn), np.cos(turn)])
    return PlacedCloud(np.column_stack([xy, z_m]), station.astype(np.uint16))


def placed(scene: Scene) -> Registration:
    """Stations at the azimuths of a scene."""
    return registration(scene.azimuths_deg, sigmas())


def surface_axis(cloud: PlacedCloud, scene: Scene) -> StraightAxis:
    """The axis of the whole surface."""
    found = lean_of_surface(cloud, MODEL, placed(scene), SurfaceQuestion("shaft", SHAFT_Z_M, "horizontal"))
    assert isinstance(found, SurfaceLean), found
    return StraightAxis(found.lean.axis.point_m, found.lean.lean)


def axis_of(model: ShaftModel) -> StraightAxis:
    """The straight axis of a model."""
    return StraightAxis(
        np.array([model.base_east_m, model.base_north_m, 0.0]), np.array([model.lean_east, model.lean_north])
    )


@dataclass(frozen=True)
class Asked:
    """What a map is measured from: the rough model, whose straight axis is taken, the round cut and the design."""

    model: ShaftModel = MODEL
    sections: RoundCut = "horizontal"
    design: DesignedShape | None = None


def map_of(
    cloud: PlacedCloud, scene: Scene, asked: Asked | None = None, axis: StraightAxis | None = None
) -> tuple[SurfaceMapCell, ...]:
    """The map of a cloud around the straight axis of the model, or another."""
    asked = asked or Asked()
    question = MapQuestion(SHAFT_Z_M, asked.sections, asked.design)
    cells = map_surface(cloud, asked.model, axis or axis_of(asked.model), placed(scene), question)
    assert isinstance(cells, tuple), cells
    return cells


def column(cells: tuple[SurfaceMapCell, ...], name: str) -> NDArray[np.float64]:
    """A column (b, 36) of a map, NaN where it is missing."""
    values = [getattr(cell, name) for cell in cells]
    return np.array([np.nan if value is None else value for value in values]).reshape(-1, 36)
