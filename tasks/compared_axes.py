"""The axes of an epoch that are compared with each other, and the difference of two of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from storage.records import ReferenceLeanRow, SliceRow, TiltRow
from tasks.accuracy import (
    Centres,
    LeanDifference,
    common_poses_covariance,
    lean_difference,
    shared_points_covariance,
    whole_surface_covariance,
)

SURFACE: Final = "surface"

PAPER: Final = "paper"

Shared = Literal["nothing", "poses", "poses and slices", "poses and all points"]
"""What the covariance of a difference takes as common to both axes."""


@dataclass(frozen=True, slots=True, eq=False)
class ComparedAxis:
    """A scheme and method of an epoch, or a reference measurement.

    ``covariance`` (2, 2) covers points and poses, ``point_covariance`` the points alone, ``propagated`` both
    by propagation; None where unknown. ``tilt``
    is None for a reference measurement; ``centres`` where slices are not stored, too.
    """

    label: str
    lean: NDArray[np.float64]
    height_m: float
    covariance: NDArray[np.float64] | None
    point_covariance: NDArray[np.float64] | None
    propagated: NDArray[np.float64] | None
    tilt: TiltRow | None
    centres: Centres | None
    n_points: int | None

    @property
    def is_surface(self) -> bool:
        """Whether it is a fit of all points at once."""
        return self.tilt is not None and self.tilt.method == SURFACE


def axis_of_scheme(row: TiltRow, slices: Sequence[SliceRow]) -> ComparedAxis:
    """Axis of a scheme and method from its row and its slices, of which there may be none."""
    good = [s for s in slices if s.state == "ok"]
    used = [s.n_points if s.n_points_fit is None else s.n_points_fit for s in good]
    return ComparedAxis(
        label=f"{row.scheme}/{row.method}",
        lean=np.array([row.lean_east, row.lean_north]),
        height_m=row.height_m,
        covariance=_matrix(row.lean_cov_ee, row.lean_cov_en, row.lean_cov_nn),
        point_covariance=_matrix(row.point_cov_ee, row.point_cov_en, row.point_cov_nn),
        propagated=_matrix(row.propagated_cov_ee, row.propagated_cov_en, row.propagated_cov_nn),
        tilt=row,
        centres=_centres(good, row.method),
        n_points=sum(used) if used else None,
    )


def axis_of_reference(row: ReferenceLeanRow) -> ComparedAxis:
    """Axis of a reference measurement; its components are independent."""
    lean = np.array([row.lean_east, row.lean_north])
    covariance = row.sigma**2 * np.eye(2)
    return ComparedAxis(row.source, lean, row.height_m, covariance, None, None, None, None, None)


def difference_of(axis: ComparedAxis, other: ComparedAxis) -> tuple[LeanDifference, Shared]:
    """Difference of the lean vectors of two axes of an epoch, and what was taken as common to both.

    A reference measurement shares nothing with ours: the covariances add up. Two schemes share the poses and, in part,
    the points. Where the slices are not known, or the points of one against all points say nothing, the points are
    taken as independent, which errs on the side of no difference.
    """
    d = axis.lean - other.lean
    if axis.tilt is None or other.tilt is None:
        return lean_difference(d, _sum(axis.covariance, other.covariance)), "nothing"
    points, shared = _of_points(axis, other)
    return lean_difference(d, _sum(points, _of_poses(axis, other))), shared


def _of_points(axis: ComparedAxis, other: ComparedAxis) -> tuple[NDArray[np.float64] | None, Shared]:
    mine, theirs = axis.point_covariance, other.point_covariance
    if mine is None or theirs is None:
        return None, "poses"
    if axis.is_surface or other.is_surface:
        whole = whole_surface_covariance(*((theirs, mine) if axis.is_surface else (mine, theirs)))
        return (mine + theirs, "poses") if whole is None else (whole, "poses and all points")
    if axis.centres is None or other.centres is None:
        return mine + theirs, "poses"
    return shared_points_covariance((mine, theirs), axis.centres, other.centres), "poses and slices"


def _of_poses(axis: ComparedAxis, other: ComparedAxis) -> NDArray[np.float64] | None:
    mine, theirs = _pose_part(axis), _pose_part(other)
    return None if mine is None or theirs is None else common_poses_covariance(mine, theirs)


def _pose_part(axis: ComparedAxis) -> NDArray[np.float64] | None:
    """What the poses add to the points, by propagation; by the stated covariance where propagation is not stored.

    A jackknife over stations, which may be what is stated, holds the points once more.
    """
    whole = axis.covariance if axis.propagated is None else axis.propagated
    return (
        None if whole is None or axis.point_covariance is None else np.asarray(whole - axis.point_covariance)
    )


def _centres(good: Sequence[SliceRow], method: str) -> Centres | None:
    # the weights of the paper are its residuals turned over; its covariance is that of equal ones
    weights = [1.0 if method == PAPER else s.weight for s in good]
    covariances = [_matrix(s.center_cov_ee, s.center_cov_en, s.center_cov_nn) for s in good]
    known_weights = [w for w in weights if w is not None]
    known = [C for C in covariances if C is not None]
    heights = {s.z_m for s, w in zip(good, weights, strict=True) if w}
    if len(known) < len(good) or len(known_weights) < len(good) or len(heights) < 2:
        return None
    return Centres(
        z_m=np.array([s.z_m for s in good]),
        thickness_m=np.array([s.thickness_m for s in good]),
        covariances_m2=np.array(known),
        weights=np.array(known_weights),
    )


def _matrix(ee: float | None, en: float | None, nn: float | None) -> NDArray[np.float64] | None:
    return None if ee is None or en is None or nn is None else np.array([[ee, en], [en, nn]])


def _sum(first: NDArray[np.float64] | None, second: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    return None if first is None or second is None else first + second
