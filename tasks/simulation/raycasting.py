"""Ray casting by open3d: the only place of this stage that knows it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.open3d_import import import_open3d
from tasks.simulation.mesh import Mesh, Surface


class _Caster(Protocol):
    """The part of open3d's RaycastingScene that is used here."""

    def cast_rays(self, rays: object) -> dict[str, object]: ...


@dataclass(frozen=True, slots=True)
class Hits:
    """What rays met first.

    ``range_m`` (n,) is the distance along the ray, infinite where it met nothing; ``surface`` (n,) is the
    code of the :class:`Surface` that was met, -1 where nothing was.
    """

    range_m: NDArray[np.float64]
    surface: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class RayScene:
    """Triangles that rays can be cast on; built once, asked often."""

    caster: _Caster
    surface_of_mesh: NDArray[np.int64]

    def cast(self, origin_m: NDArray[np.float64], directions: NDArray[np.float64]) -> Hits:
        """Cast rays from one point of the site frame.

        Parameters
        ----------
        origin_m : (3,) array
            Start of all rays, site frame; the arithmetic is of single precision (3e-5 m at 300 m).
        directions : (n, 3) array
            Unit vectors, site frame.
        """
        if origin_m.shape != (3,) or directions.ndim != 2 or directions.shape[1] != 3:
            raise ShapeError(
                f"cast needs an origin (3,) and directions (n, 3); got {origin_m.shape} and {directions.shape}"
            )
        rays = np.empty((len(directions), 6), np.float32)
        rays[:, :3] = origin_m
        rays[:, 3:] = directions
        answer = self.caster.cast_rays(import_open3d().core.Tensor.from_numpy(rays))
        range_m = answer["t_hit"].numpy().astype(np.float64)  # type: ignore[attr-defined]
        mesh = answer["geometry_ids"].numpy().astype(np.int64)  # type: ignore[attr-defined]
        met = np.isfinite(range_m)
        return Hits(range_m, np.where(met, self.surface_of_mesh[np.where(met, mesh, 0)], -1))


def build_scene(surfaces: Sequence[tuple[Surface, Mesh]]) -> RayScene:
    """Put meshes of the site frame into one scene."""
    o3d = import_open3d()
    scene = o3d.t.geometry.RaycastingScene()
    for _, mesh in surfaces:
        scene.add_triangles(
            o3d.core.Tensor.from_numpy(mesh.vertices_m.astype(np.float32)),
            o3d.core.Tensor.from_numpy(np.ascontiguousarray(mesh.triangles, np.uint32)),
        )
    return RayScene(scene, np.array([int(surface) for surface, _ in surfaces], np.int64))
