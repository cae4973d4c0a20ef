"""Cut the shaft by a scheme and fit a contour to every slice."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.contours import Contour, Section, fit_contour
from tasks.geometry.failure import FitFailure
from tasks.methods import Method
from tasks.preprocessing import ShaftModel
from tasks.slicing import SlicingScheme, cut_slices, slice_heights


def fit_sections(
    points_m: NDArray[np.float64],
    model: ShaftModel,
    scheme: SlicingScheme,
    method: Method,
    shaft_z_m: tuple[float, float],
) -> tuple[SectionFit, ...]:
    """Cut the shaft's points (n, 3), site frame, and fit the method's contour to every slice.

    Horizontal sections are taken for round (docs/estimators.md, the cut of a cone). A slice that cannot be fitted is a
    row with its reason. Slices of the robust method are thicker
    than those of the scheme, at the same heights, and end where the shaft ends.
    """
    heights_m = slice_heights(scheme, shaft_z_m)
    slices = cut_slices(points_m[:, 2], heights_m, method.thickness_m)
    return tuple(
        _fit_one(index, points_m[rows], float(z_m), model, method)
        for index, (z_m, rows) in enumerate(zip(heights_m, slices, strict=True))
    )


def centres_of(sections: Sequence[SectionFit]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres (m, 3) of the slices that have one, and their covariances (m, 2, 2), metres squared."""
    good = [s for s in sections if s.state == "ok"]
    centres = np.array([[s.center_east_m, s.center_north_m, s.z_m] for s in good], dtype=np.float64)
    covariances = np.array(
        [[[s.center_cov_ee, s.center_cov_en], [s.center_cov_en, s.center_cov_nn]] for s in good],
        dtype=np.float64,
    )
    return centres.reshape(-1, 3), covariances.reshape(-1, 2, 2)


def _fit_one(
    index: int, points_m: NDArray[np.float64], z_m: float, model: ShaftModel, method: Method
) -> SectionFit:
    section = Section(
        points_m=points_m,
        z_m=z_m,
        thickness_m=method.thickness_m,
        taper=float(model.taper_at(z_m)),
        lean_east=model.lean_east,
        lean_north=model.lean_north,
    )
    fitted = fit_contour(method.contour, section)
    if isinstance(fitted, FitFailure):
        return _failed(index, section, fitted.reason)
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


def _failed(index: int, section: Section, reason: str) -> SectionFit:
    return SectionFit(
        slice_index=index,
        z_m=section.z_m,
        thickness_m=section.thickness_m,
        n_points=len(section.points_m),
        n_points_fit=None,
        center_east_m=None,
        center_north_m=None,
        radius_m=None,
        sigma_center_m=None,
        center_cov_ee=None,
        center_cov_en=None,
        center_cov_nn=None,
        rmse_m=None,
        arc_coverage_deg=None,
        state="failed",
        reason=reason,
    )
