"""Surface model ``shaft``: any round or nearly round shaft, with bending and harmonics if the data ask for them."""

from typing import Final

from tasks.geometry.failure import FitFailure
from tasks.surface.fit import radius_intervals
from tasks.surface.form import Form
from tasks.surface.result import fit_form
from tasks.surface.surface_fit import SurfaceFit, SurfaceModel, SurfaceRequest


def fit_shaft(request: SurfaceRequest) -> SurfaceFit | FitFailure:
    """Fit axis and radius profile to all points at once.

    The radius is a spline, free at every height. The axis is a cubic at most; harmonics up to the sixth of the section, as
    far as the arc that was seen can tell them from the axis. What the data do not ask for goes again, unless it costs the
    lean nothing.
    """
    form = Form(request.start.shaft_z_m, axis_order=1, radius_intervals=radius_intervals(request.start))
    return fit_form(request, form, chooses=True, variant=MODEL.name)


MODEL: Final = SurfaceModel(
    "shaft", "axis up to a cubic, free radius profile, harmonics of the section up to the sixth", fit_shaft
)
