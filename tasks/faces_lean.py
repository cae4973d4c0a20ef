"""The lean of an epoch from the plane faces of a square tower, all points at once."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.band_axis import FittedLine, axis_of_bands, band_weights
from tasks.geometry.even_choice import even_sample
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.methods import POLYGON, Method
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.registration import Registration
from tasks.sections import centres_of, fit_slices
from tasks.shaft_slices import ShaftCloud, Slice
from tasks.slice_evidence import sum_slices
from tasks.slicing import rows_between_edges
from tasks.surface.faces import FacesFit, FacesStart, fit_faces
from tasks.uncertainty import changes_without_each, combine, leverage, moved_by_poses, state_covariance
from tasks.uncertainty.station_sums import base_leverage

MOST_BANDS: Final = 40
LEAST_BAND_M: Final = 0.5

MOST_POINTS: Final = 1_000_000
"""Of more points as many fit the planes, evenly chosen: 5 mm of noise then leave a hundredth of a millimetre, and the fit
looks at every point some 24 times. The test of the stations takes its noise for that of all."""


def fit_face_axis(
    cloud: PlacedCloud, model: ShaftModel, registration: Registration, shaft_z_m: tuple[float, float]
) -> tuple[Lean, tuple[SectionFit, ...]] | FitFailure:
    """Fit planes to the faces of a tower, and tell it band by band; poses and stations enter by the bands."""
    few = even_sample(len(cloud.points_m), MOST_POINTS)
    fit = fit_faces(cloud.points_m[few], _start(model, shaft_z_m))
    if isinstance(fit, FitFailure):
        return fit
    shaft = ShaftCloud(cloud.points_m, model)
    slices = _bands(cloud.points_m[:, 2], shaft_z_m)
    sections = fit_slices(shaft, slices, Method("surface", POLYGON, "faces", slices[0].thickness_m))
    good = np.array([section.state == "ok" for section in sections])
    if np.count_nonzero(good) < 2:
        return FitFailure(f"needs bands with a centre to tell what poses do, got {np.count_nonzero(good)}")
    sums = sum_slices(shaft, cloud.station_index, len(registration.poses), slices, sections)[good]
    return _lean(fit, sections, sums, registration), sections


def _start(model: ShaftModel, shaft_z_m: tuple[float, float]) -> FacesStart:
    return FacesStart(
        shaft_z_m=shaft_z_m,
        base_m=np.array([model.base_east_m, model.base_north_m]),
        lean=np.array([model.lean_east, model.lean_north]),
        azimuth_rad=model.face_azimuths_rad(0.0),
        twist_rad_per_m=model.twist_rad_per_m,
        half_m=model.face_distances_at(np.array(shaft_z_m)),
    )


def _bands(z_m: NDArray[np.float64], shaft_z_m: tuple[float, float]) -> list[Slice]:
    low, high = shaft_z_m
    n = int(np.clip((high - low) / LEAST_BAND_M, 2, MOST_BANDS))
    edges = np.linspace(low, high, n + 1)
    thickness_m = float(edges[1] - edges[0])
    return [
        Slice(float(bottom + thickness_m / 2), thickness_m, rows)
        for bottom, rows in zip(edges[:-1], rows_between_edges(z_m, edges), strict=True)
    ]


def _lean(
    fit: FacesFit, sections: tuple[SectionFit, ...], sums: NDArray[np.float64], registration: Registration
) -> Lean:
    centres_m, covariances_m2 = centres_of(sections)
    z_m = centres_m[:, 2]
    weights = band_weights(covariances_m2)
    positions_m = np.array([pose.position_m for pose in registration.poses])
    by_poses, base_by_poses = (
        moved_by_poses(sums, levers(z_m, weights), positions_m) for levers in (leverage, base_leverage)
    )
    poses = by_poses @ registration.covariance @ by_poses.T
    propagated = combine(fit.lean_covariance + fit.form_covariance, poses)
    stated = state_covariance(propagated, changes_without_each(sums, z_m, weights))
    # of the line at z = 0 only what the lean does to it: the middle is far better known
    base = (fit.lean_covariance + fit.form_covariance) * float(fit.middle_m[2]) ** 2
    line = FittedLine(fit.middle_m, fit.lean, fit.lean_covariance, fit.iterations)
    return Lean(
        axis=replace(axis_of_bands(line, sections, fit.bending_m), warning=fit.assumption),
        lean=fit.lean,
        covariance=stated.covariance,
        point_covariance=fit.lean_covariance,
        form_covariance=fit.form_covariance,
        propagated=propagated,
        jackknife=stated.jackknife,
        bootstrap=None,
        source=stated.source,
        misfit_p=stated.misfit_p,
        n_slices=len(sections),
        n_centres=len(centres_m),
        base_covariance=combine(base, base_by_poses @ registration.covariance @ base_by_poses.T),
    )
