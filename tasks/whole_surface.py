"""The lean of an epoch from the whole surface of its shaft (scheme S)."""

from dataclasses import dataclass, replace
from typing import Final, Literal, get_args

import numpy as np

from storage.errors import InputError
from storage.records import SectionFit
from tasks.axis import Axis, AxisCurve
from tasks.axis.bending import bending_m
from tasks.axis.centres import Centres
from tasks.band_axis import FittedLine, axis_of_bands, band_weights
from tasks.faces_lean import fit_face_axis
from tasks.geometry.axis_parameters import as_stated
from tasks.geometry.failure import FitFailure
from tasks.lean import Lean
from tasks.methods import FACES
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.registration import Registration
from tasks.sections import centres_of
from tasks.surface import (
    SURFACES,
    StationPoses,
    SurfaceFit,
    SurfacePoints,
    SurfaceRequest,
    SurfaceStart,
    fit_surface,
)
from tasks.uncertainty import combine, state_covariance

RoundCut = Literal["horizontal", "perpendicular"]


ROUND_CUTS: Final[tuple[RoundCut, ...]] = get_args(RoundCut)


def round_cut_named(name: str) -> RoundCut:
    """The cut of that name.

    Raises
    ------
    InputError
        If there is none; the message lists the known names.
    """
    for cut in ROUND_CUTS:
        if cut == name:
            return cut
    raise InputError(f"unknown round cut {name!r}; known: {', '.join(ROUND_CUTS)}")


@dataclass(frozen=True, slots=True)
class SurfaceLean:
    """A lean from the whole surface, and the surface band by band."""

    lean: Lean
    bands: tuple[SectionFit, ...]


@dataclass(frozen=True, slots=True)
class SurfaceQuestion:
    """Which surface model, between which heights, and which cut of the shaft is round."""

    model: str
    shaft_z_m: tuple[float, float]
    sections: RoundCut


def lean_of_surface(
    cloud: PlacedCloud, model: ShaftModel, registration: Registration, question: SurfaceQuestion
) -> SurfaceLean | FitFailure:
    """Fit a surface to all points of the isolated shaft and state the covariance of its lean vector.

    Raises
    ------
    InputError
        If no surface model has that name.
    """
    if question.model == FACES:
        if model.is_round:
            known = ", ".join(SURFACES)
            return FitFailure(
                f"needs a shaft with plane faces, got a round one; models of round ones: {known}"
            )
        faces = fit_face_axis(cloud, model, registration, question.shaft_z_m)
        return faces if isinstance(faces, FitFailure) else SurfaceLean(*faces)
    if not model.is_round:
        return FitFailure(f"surface model {question.model} needs a round shaft, got one with plane faces")
    fit = fit_surface(question.model, _request(cloud, model, registration, question))
    if isinstance(fit, FitFailure):
        return fit
    if fit.pose_jacobian is None:
        return FitFailure("needs the positions of the stations, got none")
    poses = fit.pose_jacobian @ registration.covariance @ fit.pose_jacobian.T
    propagated = combine(fit.point_covariance + fit.form_covariance, poses)
    stated = state_covariance(propagated, fit.station_changes)
    joint = fit.joint.own + fit.joint.form
    lean = Lean(
        axis=_axis(fit),
        lean=fit.lean,
        covariance=stated.covariance,
        point_covariance=fit.point_covariance,
        form_covariance=fit.form_covariance,
        propagated=propagated,
        jackknife=stated.jackknife,
        bootstrap=fit.bootstrap_covariance,
        source=stated.source,
        misfit_p=stated.misfit_p,
        n_slices=len(fit.bands),
        n_centres=sum(band.state == "ok" for band in fit.bands),
        base_covariance=joint[:2, :2],
        parameters=as_stated(
            fit.parameter_names, fit.parameter_values, fit.joint, stated.covariance, fit.form_covariance
        ),
    )
    return SurfaceLean(lean, fit.bands)


def _request(
    cloud: PlacedCloud, model: ShaftModel, registration: Registration, question: SurfaceQuestion
) -> SurfaceRequest:
    z_m = np.array(model.radius_z_m)
    axis = model.axis_at(z_m)
    start = SurfaceStart(z_m, axis[:, 0], axis[:, 1], np.array(model.radius_m), question.shaft_z_m)
    return SurfaceRequest(
        SurfacePoints(cloud.points_m, cloud.station_index, len(registration.poses)),
        start,
        question.sections,
        StationPoses(
            np.array([pose.position_m for pose in registration.poses]),
            registration.covariance,
            registration.frame_covariance,
        ),
    )


def _axis(fit: SurfaceFit) -> Axis:
    centres = Centres(*centres_of(fit.bands))
    bending = bending_m(centres, band_weights(centres.covariances_m2))
    line = FittedLine(fit.point_m, fit.lean, fit.point_covariance, fit.passes)
    curve = fit.curve
    return replace(
        axis_of_bands(line, fit.bands, bending),
        curve=AxisCurve(
            model=curve.model,
            reason=f"{curve.reason}; {fit.section_reason}".rstrip("; "),
            z_m=curve.z_m,
            east_m=curve.east_m,
            north_m=curve.north_m,
            base_lean=curve.base_lean,
            chord_lean=curve.chord_lean,
            base_lean_sigma=curve.base_lean_sigma,
        ),
    )
