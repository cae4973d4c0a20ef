"""Surface model ``cylinder``: one cylinder for the whole shaft."""

from typing import Final

from tasks.geometry.failure import FitFailure
from tasks.surface.form import Form
from tasks.surface.result import fit_form
from tasks.surface.surface_fit import SurfaceFit, SurfaceModel, SurfaceRequest


def fit_cylinder(request: SurfaceRequest) -> SurfaceFit | FitFailure:
    """Fit a straight axis and one radius.

    Only for shafts without taper: of a half-seen cone it makes a lean.

    References
    ----------
    The cylinder fit of reference [49] of Zhou et al. 2025.
    """
    form = Form(request.start.shaft_z_m, axis_order=1, radius_intervals=0, radius_order=0)
    return fit_form(request, form, chooses=False, variant=MODEL.name)


MODEL: Final = SurfaceModel("cylinder", "one cylinder for the whole shaft, straight axis", fit_cylinder)
