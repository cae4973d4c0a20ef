"""Cut the shaft by a scheme and fit a contour to every slice."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit, failed_section
from tasks.contours import Contour, Outline, Section, fit_contour
from tasks.geometry.failure import FitFailure
from tasks.methods import Method, weighs_sights
from tasks.preprocessing import ShaftModel
from tasks.shaft_slices import ShaftCloud, Slice, slice_cloud
from tasks.slicing import SlicingScheme

HALF_STEP_M: Final = 0.1
"""Half of the height over which the taper of a face is taken, metres."""


def fit_sections(
    points_m: NDArray[np.float64],
    model: ShaftModel,
    scheme: SlicingScheme,
    method: Method,
    shaft_z_m: tuple[float, float],
    sigma_m: NDArray[np.float64] | None = None,
) -> tuple[SectionFit, ...]:
    """Cut the shaft's points (n, 3), site frame, and fit the method's contour to every slice.

    Horizontal sections are taken for round (docs/estimators.md, the cut of a cone). A slice that cannot be fitted is a
    row with its reason. Slices of the robust method are thicker than those of the scheme, at the same heights, and end
    where the shaft ends; those of an adaptive scheme have their own thickness. ``sigma_m`` (n,) is what instrument and
    line of sight give for every point, metres, where it is known and ``needs_sights``.
    """
    cloud = ShaftCloud(points_m, model, sigma_m)
    return fit_slices(cloud, slice_cloud(cloud, scheme, method, shaft_z_m), method)


def fit_slices(cloud: ShaftCloud, slices: Sequence[Slice], method: Method) -> tuple[SectionFit, ...]:
    """Fit the method's contour to every slice of a cloud that was cut."""
    return tuple(_fit_one(index, _section_of(cloud, cut, method), method) for index, cut in enumerate(slices))


def centres_of(sections: Sequence[SectionFit]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres (m, 3) of the slices that have one, and their covariances (m, 2, 2), metres squared."""
    good = [s for s in sections if s.state == "ok"]
    centres = np.array([[s.center_east_m, s.center_north_m, s.z_m] for s in good], dtype=np.float64)
    covariances = np.array(
        [[[s.center_cov_ee, s.center_cov_en], [s.center_cov_en, s.center_cov_nn]] for s in good],
        dtype=np.float64,
    )
    return centres.reshape(-1, 3), covariances.reshape(-1, 2, 2)


def _section_of(cloud: ShaftCloud, cut: Slice, method: Method) -> Section:
    sigma_m = cloud.sigma_m if weighs_sights(method) else None
    return Section(
        points_m=cloud.points_m[cut.rows],
        z_m=cut.z_m,
        thickness_m=cut.thickness_m,
        taper=float(cloud.model.taper_at(cut.z_m)),
        lean_east=cloud.model.lean_east,
        lean_north=cloud.model.lean_north,
        sigma_m=None if sigma_m is None else sigma_m[cut.rows],
        outline=None if cloud.model.is_round else _outline_at(cloud.model, cut.z_m),
    )


def _outline_at(model: ShaftModel, z_m: float) -> Outline:
    """What the model of a shaft with plane faces knows of them at a height."""
    sigmas = [
        np.inf if face.sigma_m is None else np.interp(z_m, model.radius_z_m, face.sigma_m)
        for face in model.faces
    ]
    half_m = model.face_distances_at(np.array([z_m - HALF_STEP_M, z_m, z_m + HALF_STEP_M]))
    return Outline(
        center_m=model.axis_at(z_m),
        azimuth_rad=model.face_azimuths_rad(z_m),
        half_m=half_m[1],
        taper=(half_m[2] - half_m[0]) / (2.0 * HALF_STEP_M),
        sigma_m=np.array(sigmas),
    )


def _fit_one(index: int, section: Section, method: Method) -> SectionFit:
    fitted = fit_contour(method.contour, section)
    if isinstance(fitted, FitFailure):
        return failed_section(index, section.z_m, section.thickness_m, len(section.points_m), fitted.reason)
    return _fitted(index, section, fitted, method.contour)


def _fitted(index: int, section: Section, contour: Contour, variant: str) -> SectionFit:
    covariance = contour.covariance_m2
    return SectionFit(
        slice_index=index,
        z_m=section.z_m,
        thickness_m=section.thickness_m,
        n_points=len(section.points_m),
        n_points_fit=contour.n_used,
        center_east_m=contour.center_east_m,
        center_north_m=contour.center_north_m,
        radius_m=contour.radius_m,
        sigma_center_m=float(np.sqrt(np.trace(covariance) / 2.0)),
        center_cov_ee=float(covariance[0, 0]),
        center_cov_en=float(covariance[0, 1]),
        center_cov_nn=float(covariance[1, 1]),
        rmse_m=contour.rmse_m,
        arc_coverage_deg=contour.arc_coverage_deg,
        state="ok",
        reason=None,
        contour=contour.model or variant,
        contour_reason=contour.reason,
        noise_m=contour.noise_m,
        roundness_m=contour.roundness_m,
        ovality_m=contour.ovality_m,
        ovality_azimuth_deg=contour.ovality_azimuth_deg,
    )
