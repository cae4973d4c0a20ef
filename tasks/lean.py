"""From slice centres and station poses to a lean vector with its covariance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from storage.records import SectionFit
from tasks.axis import LEAST_FOR_BENDING, Axis, fit_axis
from tasks.geometry.failure import FitFailure
from tasks.methods import Method
from tasks.preprocessing import ShaftModel
from tasks.sections import centres_of
from tasks.tilt import lean_of_direction
from tasks.uncertainty import combine, propagate_poses


@dataclass(frozen=True, slots=True)
class Lean:
    """The axis of one scheme and method with the covariance of its lean vector.

    ``lean`` (2,) is east and north, dimensionless; ``covariance`` (2, 2) covers the points and the
    poses of the stations, ``point_covariance`` (2, 2) the points alone.
    """

    axis: Axis
    lean: NDArray[np.float64]
    covariance: NDArray[np.float64]
    point_covariance: NDArray[np.float64]
    n_slices: int
    n_centres: int


@dataclass(frozen=True, slots=True)
class StationShares:
    """Share (n,) of every station in the shaft's points, and the covariance (6n, 6n) of the poses."""

    shares: NDArray[np.float64]
    pose_covariance: NDArray[np.float64]


def lean_of_sections(
    sections: Sequence[SectionFit], method: Method, stations: StationShares, model: ShaftModel
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
    lean = lean_of_direction(axis.direction)
    poses = propagate_poses(stations.pose_covariance, stations.shares, lean)
    return Lean(
        axis=axis,
        lean=lean,
        covariance=combine(axis.lean_covariance, poses),
        point_covariance=axis.lean_covariance,
        n_slices=len(sections),
        n_centres=len(centres_m),
    )
