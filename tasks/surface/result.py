"""From a surface at its minimum to what is told of it."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.failure import FitFailure
from tasks.surface.bands import bands_of
from tasks.surface.fit import Adjusted, SurfaceTask, adjust_surface
from tasks.surface.form import Form, kept_in
from tasks.surface.profile import Profile
from tasks.surface.spread import spread_of
from tasks.surface.surface_fit import AxisForm, SurfaceFit, SurfaceRequest

CURVE_HEIGHTS: Final = 41


def fit_form(request: SurfaceRequest, form: Form, *, chooses: bool, variant: str) -> SurfaceFit | FitFailure:
    """Fit a surface of a form, or of the one around it that the data ask for, and state its covariances."""
    task = SurfaceTask(form, chooses, request.sections == "perpendicular", request.poses)
    adjusted = adjust_surface(request.cloud, request.start, task)
    if isinstance(adjusted, FitFailure):
        return adjusted
    bands = bands_of(adjusted, variant)
    if all(band.state != "ok" for band in bands):
        return FitFailure(f"needs bands of the shaft with a centre, got none among {len(bands)}")
    spread = spread_of(adjusted, request.cloud.n_stations, request.poses)
    profile = adjusted.profile
    middle = profile.origin_m + profile.values_m[[0, profile.form.n_axis]]
    return SurfaceFit(
        lean=profile.lean,
        point_m=np.array([middle[0], middle[1], profile.form.middle_m]),
        point_covariance=spread.points,
        form_covariance=spread.form,
        bootstrap_covariance=spread.bootstrap,
        station_changes=spread.station_leans,
        pose_jacobian=spread.pose_jacobian,
        bands=bands,
        curve=_curve(adjusted),
        section_reason="" if adjusted.choice is None else adjusted.choice.section_reason,
        common_sigma_m=adjusted.blocks.common_sigma_m,
        n_used=int(adjusted.cells.n_used.sum()),
        coverage_deg=adjusted.coverage_deg,
        passes=adjusted.passes,
        parameter_names=spread.parameter_names,
        parameter_values=spread.parameter_values,
        joint=spread.joint,
    )


def _curve(adjusted: Adjusted) -> AxisForm:
    """The axis with the terms that the data ask for; those only kept along do not count as bending."""
    profile, choice = adjusted.profile, adjusted.choice
    form, normal = profile.form, adjusted.normal
    values = profile.values_m
    model, reason = "straight", "the model knows no bending"
    if choice is not None:
        small = replace(form, axis_order=choice.asked_for.axis_order)
        places = kept_in(small, form)
        form, normal, values = small, normal.kept(places), values[places]
        model, reason = choice.axis_model, choice.axis_reason
    told = Profile(form, values, profile.origin_m)
    z_m = np.linspace(*form.shaft_z_m, CURVE_HEIGHTS)
    axis = told.axis_at(z_m) + profile.origin_m
    tangent = _tangent(form)
    covariance = np.linalg.inv(normal.matrix)
    sigma = float(np.sqrt(np.trace(tangent @ covariance @ tangent.T) / 2.0))
    return AxisForm(
        model=model,
        reason=reason,
        z_m=z_m,
        east_m=axis[:, 0],
        north_m=axis[:, 1],
        base_lean=np.asarray(tangent @ values),
        base_lean_sigma=sigma,
        chord_lean=np.asarray((axis[-1] - axis[0]) / (z_m[-1] - z_m[0])),
    )


def _tangent(form: Form) -> NDArray[np.float64]:
    """Matrix (2, p) that takes the slope at the foot out of the coefficients."""
    order = np.arange(form.n_axis)
    slope = -((-1.0) ** order) * order * (order + 1) / 2.0 / form.half_m
    matrix = np.zeros((2, form.size))
    matrix[0, : form.n_axis] = slope
    matrix[1, form.n_axis : 2 * form.n_axis] = slope
    return matrix
