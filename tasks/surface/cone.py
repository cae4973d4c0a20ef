"""Surface model ``cone``: one cone for the whole shaft, with a straight axis."""

from typing import Final

from tasks.geometry.failure import FitFailure
from tasks.surface.form import Form
from tasks.surface.result import fit_form
from tasks.surface.surface_fit import SurfaceFit, SurfaceModel, SurfaceRequest


def fit_cone(request: SurfaceRequest) -> SurfaceFit | FitFailure:
    """Fit a straight axis and a radius that is linear in height.

    On a half-seen shaft whose taper is not even the axis leans towards what the taper hides.

    References
    ----------
    The parametric model of reference [26] of Zhou et al. 2025, which states base centre, azimuth and tilt with sigmas.
    """
    form = Form(request.start.shaft_z_m, axis_order=1, radius_intervals=0, radius_order=1)
    return fit_form(request, form, chooses=False, variant=MODEL.name)


MODEL: Final = SurfaceModel("cone", "one cone for the whole shaft, straight axis", fit_cone)
