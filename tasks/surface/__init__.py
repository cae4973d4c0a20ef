"""Fit the whole surface of a shaft at once: axis and radius profile from all points (scheme S).

A model is one file of this folder that defines ``MODEL``; it is found by itself.
"""

from typing import Final

from tasks.geometry.failure import FitFailure
from tasks.geometry.variants import choose, discover
from tasks.surface.cells import SurfacePoints
from tasks.surface.fit import SurfaceStart
from tasks.surface.poses import StationPoses
from tasks.surface.surface_fit import SurfaceFit, SurfaceModel, SurfaceRequest

SURFACES: Final[dict[str, SurfaceModel]] = discover(__name__, "MODEL", SurfaceModel)
"""The models that are shipped, by name."""

__all__ = [
    "SURFACES",
    "StationPoses",
    "SurfaceFit",
    "SurfaceModel",
    "SurfacePoints",
    "SurfaceRequest",
    "SurfaceStart",
    "fit_surface",
]


def fit_surface(name: str, request: SurfaceRequest) -> SurfaceFit | FitFailure:
    """Fit the model of that name to all points of a shaft.

    Raises
    ------
    InputError
        If no model has that name.
    """
    return choose(SURFACES, name, "surface model").fit(request)
