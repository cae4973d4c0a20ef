"""The covariance of a lean that comes from a surface: points, form, poses of the stations; and its two checks."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tasks.geometry.axis_parameters import JointParts
from tasks.surface.bending import bent_beside
from tasks.surface.cells import SECTORS, Cells
from tasks.surface.choice import FULL_COVERAGE_DEG
from tasks.surface.fit import Adjusted
from tasks.surface.form import Form, kept_in
from tasks.surface.joint import names_of, rows_of, scale_of, values_of
from tasks.surface.normal import Normal, Weighed, mean_radius_m, normal_of, prior_matrix
from tasks.surface.pieces import small_equations
from tasks.surface.poses import StationPoses, by_own_pose, jacobian_of_poses
from tasks.surface.wall_form import wall_form
from tasks.surface.wall_modes import wall_modes

HEIGHTS_OF_CLUSTER: Final = 24
SECTORS_OF_CLUSTER: Final = 9
"""Pieces of the wall that are drawn together: a 24th of its height by 45 degrees."""

RESAMPLES: Final = 400
SEED: Final = 20250314


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Covariances of a lean vector, each (2, 2), dimensionless.

    Attributes
    ----------
    points : array
        From the noise of the points.
    form : array
        From the form of the wall that the surface does not follow, and from harmonics that were left out because the arc
        that was seen cannot tell them from the axis.
    bootstrap : array or None
        Both, by a bootstrap over pieces of the wall; None with too few of them for the unknowns.
    station_leans : (s, 2) array or None
        What the lean changes by if a station that saw the shaft is left out; None with one such station.
    pose_jacobian : (2, 6 s) array or None
        What the lean changes by with the pose parameters of the stations; None where their positions are not known.
    parameter_names, parameter_values : tuple of str, (p,) array
        Parameters of axis and radius (``tasks.surface.joint``), site frame.
    joint : JointParts
        Their joint covariance: points and poses, and the form of the wall.
    """

    points: NDArray[np.float64]
    form: NDArray[np.float64]
    bootstrap: NDArray[np.float64] | None
    station_leans: NDArray[np.float64] | None
    pose_jacobian: NDArray[np.float64] | None
    parameter_names: tuple[str, ...]
    parameter_values: NDArray[np.float64]
    joint: JointParts


def spread_of(adjusted: Adjusted, n_stations: int, poses: StationPoses | None) -> Spread:
    """State how far the lean of a surface may be off.

    Parameters
    ----------
    adjusted : Adjusted
        The surface at its minimum.
    n_stations : int
        Stations of the cloud.
    poses : StationPoses or None
        Where they stood and how well that is known.
    """
    equations = _Equations(adjusted.normal, adjusted.profile.form)
    lean_pull = adjusted.normal.pull(equations.lean_of)
    small, wide = _asked_for(adjusted), bent_beside(adjusted)
    return Spread(
        points=_noise(adjusted, lean_pull),
        form=_wall(adjusted, lean_pull)
        + _out_of_round(adjusted, equations.lean_of)
        + _left_out(adjusted, lean_pull),
        bootstrap=_bootstrap(adjusted.cells, small),
        station_leans=_without_each(adjusted.cells, _straightened(adjusted), n_stations),
        pose_jacobian=None if poses is None else _by_poses(adjusted, lean_pull, poses),
        parameter_names=names_of(wide.profile.form),
        parameter_values=values_of(wide.profile),
        joint=_joint(wide, poses),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Equations:
    """Normal equations of a form, and the places of the slopes, which count once over ``half_m``."""

    normal: Normal
    form: Form

    @property
    def lean_of(self) -> NDArray[np.float64]:
        """Matrix (2, p) that takes the lean out of coefficients."""
        pick = np.zeros((2, self.form.size))
        pick[[0, 1], self.form.lean_rows] = 1.0 / self.form.half_m
        return pick


def _asked_for(adjusted: Adjusted) -> _Equations:
    """The smallest form that the data ask for: checks must not fail on terms that are only kept along."""
    form = adjusted.profile.form
    if adjusted.choice is None or adjusted.choice.asked_for == form:
        return _Equations(adjusted.normal, form)
    small = adjusted.choice.asked_for
    return _Equations(adjusted.normal.kept(kept_in(small, form)), small)


def _straightened(adjusted: Adjusted) -> _Equations:
    """The form with no more bending than the data ask for: a station may be all that fixes the rest."""
    form = adjusted.profile.form
    if adjusted.choice is None:
        return _Equations(adjusted.normal, form)
    small = replace(form, axis_order=adjusted.choice.asked_for.axis_order)
    return _Equations(adjusted.normal.kept(kept_in(small, form)), small)


def _joint(adjusted: Adjusted, poses: StationPoses | None) -> JointParts:
    """Joint covariance (p, p) of the parameters of axis and radius."""
    form = adjusted.profile.form
    scale = scale_of(form)
    rows = rows_of(form) * scale[:, None]
    pull = adjusted.normal.pull(rows)
    own, frame = _noise(adjusted, pull), np.zeros((len(pull), len(pull)))
    if poses is not None:
        jacobian = _by_poses(adjusted, pull, poses)
        own = own + jacobian @ poses.covariance @ jacobian.T
        if poses.frame_covariance is not None:
            frame = jacobian @ poses.frame_covariance @ jacobian.T
    wall = (
        wall_form(adjusted.cells, adjusted.normal, pull)
        + _out_of_round(adjusted, rows)
        + _left_out(adjusted, pull)
    )
    both = np.outer(scale, scale)
    return JointParts(np.asarray(own / both), np.asarray(wall / both), np.asarray(frame / both))


def _noise(adjusted: Adjusted, pull: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (k, k) from the noise of the points alone."""
    return np.asarray(pull * (adjusted.cells.robust_price / adjusted.cells.weight) @ pull.T)


def _wall(adjusted: Adjusted, pull: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (2, 2) of the form of the wall: by its pieces, or by its waves where that is larger and can be told."""
    pieces = wall_form(adjusted.cells, adjusted.normal, pull)
    if adjusted.choice is None or adjusted.coverage_deg < FULL_COVERAGE_DEG:
        return pieces
    weighed = Weighed(adjusted.cells, adjusted.blocks.share, adjusted.normal.poses)
    waves = wall_modes(weighed, adjusted.profile.form, adjusted.profile.values_m)
    return pieces if np.trace(pieces) >= np.trace(waves) else waves


def _left_out(adjusted: Adjusted, pull: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (k, k) by harmonics that were left out, as far as the points leave them open."""
    form = adjusted.profile.form
    if form.harmonics >= adjusted.full.harmonics:
        return np.zeros((len(pull), len(pull)))
    large = replace(adjusted.full, axis_order=form.axis_order, free=(form.harmonics, form.harmonic_order))
    start = np.zeros(large.size)
    start[kept_in(form, large)] = adjusted.profile.values_m
    weighed = Weighed(adjusted.cells, adjusted.blocks.share, adjusted.normal.poses)
    normal = normal_of(weighed, large, start)
    lobes = np.flatnonzero(large.held)
    open_m2 = normal.covariance()[np.ix_(lobes, lobes)]
    follows = pull @ normal.design[:, lobes]
    return np.asarray(follows @ open_m2 @ follows.T)


def _out_of_round(adjusted: Adjusted, rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance (k, k) that harmonics which are held near zero may cause."""
    form, values_m = adjusted.profile.form, adjusted.profile.values_m
    prior = prior_matrix(form, mean_radius_m(form, values_m))[np.ix_(form.held, form.held)]
    gain = (rows @ adjusted.normal.covariance())[:, form.held]
    return np.asarray(gain @ prior @ gain.T)


def _by_poses(adjusted: Adjusted, pull: NDArray[np.float64], poses: StationPoses) -> NDArray[np.float64]:
    """Change (k, 6 s) with rotations (east, north, up) and shifts of the stations."""
    own = by_own_pose(adjusted.cells, adjusted.profile, poses)
    return jacobian_of_poses(adjusted.cells, own, pull, len(poses.positions_m))


def _without_each(cells: Cells, small: _Equations, n_stations: int) -> NDArray[np.float64] | None:
    """Change (s, 2) of the lean with each of the s stations that have points left out; None where the rest fixes no axis."""
    present = np.unique(cells.station)
    if len(present) < 2:
        return None
    pieces = small_equations(cells, small.normal, cells.station, n_stations)
    whole = pieces.solved(np.ones(n_stations))
    changes = np.zeros((len(present), 2))
    for row, station in enumerate(present):
        others = np.ones(n_stations)
        others[station] = 0.0
        try:
            changes[row] = small.lean_of @ (pieces.solved(others) - whole)
        except np.linalg.LinAlgError:
            return None
    return changes


def _bootstrap(cells: Cells, small: _Equations) -> NDArray[np.float64] | None:
    """Covariance (2, 2) of the lean over resamples of pieces of the wall, each with its normal equations."""
    n_heights = int(cells.height.max()) + 1
    key = (cells.height * HEIGHTS_OF_CLUSTER // n_heights) * SECTORS + cells.sector // SECTORS_OF_CLUSTER
    _, cluster = np.unique(key, return_inverse=True)
    n, p = int(cluster.max()) + 1, small.form.size
    if n <= 2 * p:
        return None
    pieces = small_equations(cells, small.normal, cluster, n)
    rng = np.random.default_rng(SEED)
    counts = rng.multinomial(n, np.full(n, 1.0 / n), size=RESAMPLES).astype(np.float64)
    leans = np.stack([small.lean_of @ pieces.solved(count) for count in counts])
    # what the unknowns took out of the residuals
    return np.asarray(np.cov(leans.T) * n / (n - p))
