"""From slice centres and station poses to a lean vector with its covariance."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.axis import LEAST_FOR_BENDING, Axis, AxisCurve, fit_axis
from tasks.axis.centres import Centres
from tasks.axis.cone_cut import take_out_cone_cut
from tasks.axis.line import direction_of_lean
from tasks.geometry.axis_parameters import LEAN, AxisParameters, as_stated
from tasks.geometry.failure import FitFailure
from tasks.methods import Method
from tasks.preprocessing import ShaftModel
from tasks.sections import centres_of
from tasks.tilt import lean_of_direction
from tasks.uncertainty import (
    PlacedStations,
    SlicedShaft,
    Source,
    base_leverage,
    bootstrap_slices,
    changes_without_each,
    combine,
    form_of_slices,
    joint_parts,
    joint_slices,
    leverage,
    moved_by_poses,
    pose_jacobian,
    state_covariance,
)

if TYPE_CHECKING:
    from tasks.registration import Registration


@dataclass(frozen=True, slots=True)
class Lean:
    """The axis of one scheme and method with the covariance of its lean vector.

    Attributes
    ----------
    axis : Axis
        The axis.
    lean : (2,) array
        East and north over up, dimensionless.
    covariance : (2, 2) array
        The covariance that is stated: ``propagated``, or with ``source`` "jackknife" the larger of both.
    point_covariance : (2, 2) array
        The part of the points alone.
    form_covariance : (2, 2) array
        The part of the wall: its form beyond the model, and what the arc that was seen cannot tell.
    propagated : (2, 2) array
        Points, form and the poses of the stations.
    jackknife, bootstrap : (2, 2) array or None
        By leaving out one station after the other, and by resampling pieces of the surface; None where they do not exist.
    source : "propagation" or "jackknife"
        Where ``covariance`` comes from.
    misfit_p : float or None
        Probability of stations that disagree like these if their stated errors hold; None with too few stations.
    n_slices, n_centres : int
        Slices, and those of them that gave a centre.
    cone_factor : float or None
        What the lean was divided by, because the shaft is round across its axis and was cut in the horizontal.
    base_covariance : (2, 2) array or None
        Covariance of the axis at z = 0 from points, form and poses, square metres.
    parameters : AxisParameters or None
        Axis and radius with their joint covariance, for comparing epochs; None where the radii are unknown.
    """

    axis: Axis
    lean: NDArray[np.float64]
    covariance: NDArray[np.float64]
    point_covariance: NDArray[np.float64]
    form_covariance: NDArray[np.float64]
    propagated: NDArray[np.float64]
    jackknife: NDArray[np.float64] | None
    bootstrap: NDArray[np.float64] | None
    source: Source
    misfit_p: float | None
    n_slices: int
    n_centres: int
    cone_factor: float | None = None
    base_covariance: NDArray[np.float64] | None = None
    parameters: AxisParameters | None = None


@dataclass(frozen=True, slots=True, eq=False)
class StationEvidence:
    """What the stations say of the slices.

    ``sums`` (m, s, 3, 10) are those of every slice (``tasks.uncertainty.sum_by_station``), ``positions_m`` (s, 3) the
    stations in the site frame, ``pose_covariance`` (6 s, 6 s) that of their poses and ``frame_covariance`` the part of it
    that the frame of the reference epoch brings along, or None.
    """

    sums: NDArray[np.float64]
    positions_m: NDArray[np.float64]
    pose_covariance: NDArray[np.float64]
    frame_covariance: NDArray[np.float64] | None = None


def evidence_of(sums: NDArray[np.float64], registration: "Registration") -> StationEvidence:
    """Put the sums of the slices together with where the stations stood."""
    positions_m = np.array([pose.position_m for pose in registration.poses])
    return StationEvidence(sums, positions_m, registration.covariance, registration.frame_covariance)


def lean_of_sections(
    sections: Sequence[SectionFit], method: Method, stations: StationEvidence, model: ShaftModel
) -> Lean | FitFailure:
    """Fit the method's axis to the centres and state the covariance of its lean vector.

    Few centres cannot tell bending from noise: how far ``model`` bends off its straight line at each of them is added
    to its covariance, so that a line through two ends of a bent shaft does not look better than it is.
    """
    centres_m, covariances_m2 = centres_of(sections)
    if len(centres_m) < LEAST_FOR_BENDING:
        bend_m = model.axis_at(centres_m[:, 2]) - model.straight_axis_at(centres_m[:, 2])
        covariances_m2 = covariances_m2 + bend_m[:, :, None] * bend_m[:, None, :]
    axis = fit_axis(method.axis, centres_m, covariances_m2)
    if isinstance(axis, FitFailure):
        return axis
    good = np.array([section.state == "ok" for section in sections])
    sums = stations.sums[good]
    jacobian = pose_jacobian(sums, centres_m[:, 2], axis.levers, stations.positions_m)
    form = form_of_slices(centres_m, leverage(centres_m[:, 2], axis.levers), axis.lean_covariance)
    propagated = combine(axis.lean_covariance + form, jacobian @ stations.pose_covariance @ jacobian.T)
    stated = state_covariance(propagated, changes_without_each(sums, centres_m[:, 2], axis.levers))
    joint = _joint(sections, Centres(centres_m, covariances_m2), axis, sums)
    return Lean(
        axis=axis,
        lean=lean_of_direction(axis.direction),
        covariance=stated.covariance,
        point_covariance=axis.lean_covariance,
        form_covariance=form,
        propagated=propagated,
        jackknife=stated.jackknife,
        bootstrap=bootstrap_slices(centres_m, axis.levers),
        source=stated.source,
        misfit_p=stated.misfit_p,
        n_slices=len(sections),
        n_centres=len(centres_m),
        base_covariance=_base_covariance(axis, Centres(centres_m, covariances_m2), sums, stations),
        parameters=None if joint is None else _parameters(joint, axis, stations, stated.covariance, form),
    )


def _joint(
    sections: Sequence[SectionFit], centres: Centres, axis: Axis, sums: NDArray[np.float64]
) -> SlicedShaft | None:
    """The slices as axis and radius are taken out of them; None where the method states no radius."""
    good = [section for section in sections if section.state == "ok"]
    radii = [section.radius_m for section in good if section.radius_m is not None]
    if len(radii) < len(good):
        return None
    low = min(section.z_m - section.thickness_m / 2.0 for section in sections)
    high = max(section.z_m + section.thickness_m / 2.0 for section in sections)
    return SlicedShaft(
        centres.points_m, centres.covariances_m2, np.array(radii), axis.levers, sums, (low, high)
    )


def _parameters(
    shaft: SlicedShaft,
    axis: Axis,
    stations: StationEvidence,
    stated: NDArray[np.float64],
    form: NDArray[np.float64],
) -> AxisParameters:
    """Axis and radius with a joint covariance in which the lean has the one that is stated."""
    found = joint_slices(shaft)
    poses = PlacedStations(stations.positions_m, stations.pose_covariance, stations.frame_covariance)
    share = float(np.trace(form) / np.trace(axis.lean_covariance))
    parts = joint_parts(shaft, found.rows, poses, share)
    values = found.values.copy()
    values[:2] = axis.point_m[:2] - axis.point_m[2] * axis.lean
    values[2:4] = axis.lean
    return as_stated(found.names, values, parts, stated, form)


def _base_covariance(
    axis: Axis, centres: Centres, sums: NDArray[np.float64], stations: StationEvidence
) -> NDArray[np.float64]:
    """Covariance (2, 2) of the axis at z = 0.

    The centres count with as much more than their own covariances as they do in the lean.
    """
    z_m = centres.points_m[:, 2]
    along, base = leverage(z_m, axis.levers), base_leverage(z_m, axis.levers)
    from_lean = np.trace(axis.lean_covariance) / np.trace(np.tensordot(along**2, centres.covariances_m2, 1))
    points = from_lean * np.tensordot(base**2, centres.covariances_m2, 1)
    jacobian = moved_by_poses(sums, base, stations.positions_m)
    return combine(points, jacobian @ stations.pose_covariance @ jacobian.T)


def without_cone(lean: Lean, taper: float) -> Lean:
    """Take out of a lean that horizontal cuts of a cone lean more than its axis; ``taper`` is that of the radius."""
    length = float(np.sqrt(1.0 + lean.lean @ lean.lean))
    upright = take_out_cone_cut(lean.lean, lean.covariance, taper / length)
    factor = float(np.linalg.norm(lean.lean) / np.linalg.norm(upright.lean)) if lean.lean.any() else 1.0
    square = factor**2
    axis = replace(
        lean.axis,
        direction=direction_of_lean(upright.lean),
        lean_covariance=lean.axis.lean_covariance / square,
        curve=None if lean.axis.curve is None else _upright(lean.axis.curve, factor),
    )
    return replace(
        lean,
        axis=axis,
        lean=upright.lean,
        covariance=upright.covariance,
        point_covariance=lean.point_covariance / square,
        form_covariance=lean.form_covariance / square,
        propagated=lean.propagated / square,
        jackknife=None if lean.jackknife is None else lean.jackknife / square,
        parameters=None if lean.parameters is None else lean.parameters.scaled(LEAN, 1.0 / factor),
        bootstrap=None if lean.bootstrap is None else lean.bootstrap / square,
        cone_factor=factor,
    )


def _upright(curve: AxisCurve, factor: float) -> AxisCurve:
    """Tangent and chord of an axis without the factor of the cone."""
    sigma = None if curve.base_lean_sigma is None else curve.base_lean_sigma / factor
    return replace(
        curve,
        base_lean=curve.base_lean / factor,
        chord_lean=curve.chord_lean / factor,
        base_lean_sigma=sigma,
    )
