"""Ray casting by open3d, and the import of open3d itself: the only place of this stage that knows it."""

import ctypes
import importlib
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError, TiltwatchError
from tasks.simulation.mesh import Mesh, Surface

_LIBRARY: Final = "libusb"


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


def import_open3d() -> ModuleType:
    """Import open3d, with the libusb of the wheel ``libusb-package`` where Linux has none.

    Raises
    ------
    TiltwatchError
        If open3d cannot be loaded; the message says what to install.
    """
    try:
        return importlib.import_module("open3d")
    except ImportError as error:
        if _LIBRARY not in str(error) or not sys.platform.startswith("linux"):
            raise TiltwatchError(_advice(error)) from error
    for name in [name for name in sys.modules if name.partition(".")[0] == "open3d"]:
        del sys.modules[name]
    try:
        # open3d asks the linker for libusb by name; one that is already loaded satisfies it
        path = importlib.import_module("libusb_package").get_library_path()
        ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
        return importlib.import_module("open3d")
    except (ImportError, OSError) as error:
        raise TiltwatchError(_advice(error)) from error


def _advice(error: Exception) -> str:
    return (
        f"the simulation needs open3d, which does not load here ({error}); install the python packages of "
        "requirements.lock, and on linux the system's libusb-1.0 or the package libusb-package; "
        "a slim image also needs libegl1, libgl1, libx11-6, libudev1 and libidn2-0"
    )
