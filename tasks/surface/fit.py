"""Fit a surface to all points of a shaft: robust, streaming, with the form that the data ask for."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.failure import FitFailure
from tasks.geometry.rows_between import rows_between
from tasks.surface.blocks import Blocks, weigh_blocks
from tasks.surface.cells import SECTORS, Cells, Grid, SurfacePoints, sum_cells
from tasks.surface.choice import FULL_COVERAGE_DEG, Choice, Evidence, choose_form, fullest_form
from tasks.surface.form import Form, design, kept_in
from tasks.surface.noise import noise_by_direction, noise_of_all
from tasks.surface.normal import Normal, Weighed, mean_radius_m, normal_of, normal_with
from tasks.surface.poses import StationPoses, by_own_pose, by_pose_factors
from tasks.surface.profile import Profile, ProfileTable, tabulate
from tasks.surface.wall_modes import wall_variance

LEAST_POINTS: Final = 200
"""Fewer points make no surface: its radius and its axis alone have some 20 unknowns."""

SAMPLE: Final = 200_000
"""Points, evenly taken, that bring the surface near enough for all of them to be looked at only a few times."""

MOST_STEPS: Final = 40
SWINGING_STEPS: Final = 15
"""From then on a step back is halved: on a smooth wall the weights of points at the edge of the robust loss can make radii
swing by micrometres for ever, with steps as long there as back."""

MOST_PASSES: Final = 12
STRICT_PASSES: Final = 6
"""From then on it is enough that the axis holds still within ``NEAR_SIGMAS``: a point that is now in one cell, now in the
next, would move some radius for ever."""

FREE_SCALES: Final = 6
"""Steps in which the noise is estimated anew; then it stays, or its median swings for ever."""

NEAR_SIGMAS: Final = 0.1
SETTLED_SIGMAS: Final = 0.01
"""Finished when no coefficient moves by more than this share of its own standard deviation: on the sample, which only
brings the surface near, and on all points."""

NOTHING_RADII: Final = 1e-7
"""A step of this part of the radius moves nothing that one could measure: 0.4 micrometres on a shaft of 4 m."""

CELLS_PER_INTERVAL: Final = 4
HEIGHTS_OF_BLOCK: Final = 3

COVERAGE_BANDS: Final = 10

LEAST_COVERAGE_DEG: Final = 30.0
"""On a shorter arc the axis hangs on how round the shaft is."""

NO_POINT_NEAR: Final = FitFailure("the surface ran away: needed points near it, got none")


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceStart:
    """A rough shaft: axis and radius at heights (k,), ascending, site frame, metres, and the ends of the shaft."""

    z_m: NDArray[np.float64]
    east_m: NDArray[np.float64]
    north_m: NDArray[np.float64]
    radius_m: NDArray[np.float64]
    shaft_z_m: tuple[float, float]


@dataclass(frozen=True, slots=True)
class SurfaceTask:
    """How a surface is to be fitted.

    ``form`` says what it may do at least; where ``chooses`` is true, bending and harmonics are added if the data ask for
    them. ``across`` takes sections for round across the axis, else in the horizontal. ``poses`` are the stations, where
    they are known.
    """

    form: Form
    chooses: bool
    across: bool
    poses: StationPoses | None


@dataclass(frozen=True, slots=True, eq=False)
class Adjusted:
    """A surface at its minimum, with everything that its covariance is made of.

    ``noise_m`` (stations, SECTORS) is the noise of the points, ``full`` the fullest form that was tried.
    """

    profile: Profile
    cells: Cells
    grid: Grid
    blocks: Blocks
    normal: Normal
    choice: Choice | None
    full: Form
    noise_m: NDArray[np.float64]
    coverage_deg: float
    passes: int


def radius_intervals(start: SurfaceStart) -> int:
    """Intervals of the spline of the radius: about a radius tall, 8 to 40."""
    low, high = start.shaft_z_m
    return int(np.clip(round((high - low) / float(start.radius_m.mean())), 8, 40))


def adjust_surface(cloud: SurfacePoints, start: SurfaceStart, task: SurfaceTask) -> Adjusted | FitFailure:
    """Bring a surface to the minimum of a robust loss over all points.

    A sample brings the surface and the noise of every station near; then all points are summed up in cells, and what
    the points of a block have in common lowers the weight of dense ones. The form is chosen from the fullest one.
    """
    if len(cloud.station_index) and int(cloud.station_index.max()) >= cloud.n_stations:
        raise ShapeError(
            f"adjust_surface needs stations below {cloud.n_stations}; got {int(cloud.station_index.max())}"
        )
    inside = _within(cloud, start.shaft_z_m)
    if len(inside.points_m) < LEAST_POINTS:
        return FitFailure(f"needs {LEAST_POINTS} points on the shaft, got {len(inside.points_m)}")
    sample = _sample(inside)
    grid = _grid(start)
    rough = start_profile(start, task.form)
    noise = noise_of_all(sample, _table(rough, task), float(start.radius_m.mean()))
    coverage = _coverage_deg(_cells(sample, rough, grid, task, noise))
    if coverage < LEAST_COVERAGE_DEG:
        return FitFailure(f"needs {LEAST_COVERAGE_DEG:g} deg of the circumference, got {coverage:.0f} deg")
    full = fullest_form(task.form, coverage) if task.chooses else task.form
    # terms that an arc can hardly tell from the axis are tried on the normal equations alone
    steady = full
    if task.chooses and coverage < FULL_COVERAGE_DEG:
        steady = replace(full, axis_order=task.form.axis_order, free=(0, 0))
    try:
        near = _settle(sample, start_profile(start, steady), grid, task)
        if isinstance(near, FitFailure):
            return near
        noise = noise_by_direction(sample, _table(near, task), float(start.radius_m.mean()))
        return _finish(inside, near, _Frame(grid, task, full, noise, coverage))
    except np.linalg.LinAlgError:
        return FitFailure("needs points that fix axis and radius, got a singular system")


def start_profile(start: SurfaceStart, form: Form) -> Profile:
    """Take the coefficients of a form from a rough shaft."""
    z = np.linspace(*start.shaft_z_m, 200)
    origin = np.array(
        [np.interp(form.middle_m, start.z_m, column) for column in (start.east_m, start.north_m)]
    )
    axis = np.column_stack([np.interp(z, start.z_m, column) for column in (start.east_m, start.north_m)])
    coefficients = np.linalg.lstsq(form.axis_terms(z), axis - origin, rcond=None)[0]
    radius = np.linalg.lstsq(form.radius_terms(z), np.interp(z, start.z_m, start.radius_m), rcond=None)[0]
    values = np.zeros(form.size)
    values[: 2 * form.n_axis] = coefficients.T.ravel()
    values[2 * form.n_axis : 2 * form.n_axis + form.n_radius] = radius
    return Profile(form, values, origin)


def _within(cloud: SurfacePoints, shaft_z_m: tuple[float, float]) -> SurfacePoints:
    rows = rows_between(cloud.points_m[:, 2], *shaft_z_m)
    return SurfacePoints(cloud.points_m[rows], cloud.station_index[rows], cloud.n_stations)


def _sample(cloud: SurfacePoints) -> SurfacePoints:
    if len(cloud.points_m) <= SAMPLE:
        return cloud
    rows = np.linspace(0, len(cloud.points_m) - 1, SAMPLE).astype(np.intp)
    return SurfacePoints(cloud.points_m[rows], cloud.station_index[rows], cloud.n_stations)


def _grid(start: SurfaceStart) -> Grid:
    low, high = start.shaft_z_m
    n_heights = CELLS_PER_INTERVAL * radius_intervals(start)
    return Grid(low, (high - low) / n_heights, n_heights)


def _table(profile: Profile, task: SurfaceTask) -> ProfileTable:
    return tabulate(profile, across=task.across)


def _cells(
    cloud: SurfacePoints, profile: Profile, grid: Grid, task: SurfaceTask, noise: NDArray[np.float64]
) -> Cells:
    return sum_cells(cloud, _table(profile, task), grid, noise)


def _coverage_deg(cells: Cells) -> float:
    """Circumference with points, mean over bands of the height, degrees."""
    n_heights = int(cells.height.max()) + 1
    band = cells.height * COVERAGE_BANDS // n_heights
    seen = np.unique(band * SECTORS + cells.sector)
    return 360.0 / SECTORS * len(seen) / len(np.unique(band))


def _settle(sample: SurfacePoints, profile: Profile, grid: Grid, task: SurfaceTask) -> Profile | FitFailure:
    """Iterate on the sample, its noise estimated anew at first, until the steps are small."""
    radius_m = float(np.abs(profile.values_m).max())
    last = np.zeros(len(profile.values_m))
    for number in range(MOST_STEPS):
        if number < FREE_SCALES:
            noise = noise_by_direction(sample, _table(profile, task), radius_m)
        cells = _cells(sample, profile, grid, task, noise)
        if not len(cells.weight):
            return NO_POINT_NEAR
        weighed = Weighed(cells, np.ones(len(cells.weight)), _pose_terms(cells, profile, task))
        normal = normal_of(weighed, profile.form, profile.values_m)
        step = normal.step()
        if number >= SWINGING_STEPS and step @ normal.matrix @ last < 0.0:
            step = 0.5 * step
        profile, last = profile.moved(step), step
        if not np.isfinite(profile.values_m).all():
            return FitFailure("the surface ran away: needed finite coefficients")
        if number >= FREE_SCALES and _is_small(step, profile, normal, NEAR_SIGMAS):
            return profile
    return FitFailure(f"the surface needed to settle within {MOST_STEPS} steps, it did not")


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    grid: Grid
    task: SurfaceTask
    full: Form
    noise_m: NDArray[np.float64]
    coverage_deg: float


def _finish(cloud: SurfacePoints, near: Profile, frame: _Frame) -> Adjusted | FitFailure:
    """Look at all points, choose the form on their cells, and look again until nothing moves."""
    profile, choice = near, None
    for passed in range(1, MOST_PASSES + 1):
        cells = _cells(cloud, profile, frame.grid, frame.task, frame.noise_m)
        if not len(cells.weight):
            return NO_POINT_NEAR
        if passed == 1 and frame.task.chooses:
            choice, profile, cells = _choose(profile, cells, frame)
        before = profile
        profile, cells, blocks, normal = _on_cells(profile, cells, frame.task)
        change = profile.values_m - before.values_m
        is_strict = passed <= STRICT_PASSES
        if (
            _is_small(change, profile, normal, SETTLED_SIGMAS)
            if is_strict
            else _holds(change, profile, normal)
        ):
            return Adjusted(
                profile,
                cells,
                frame.grid,
                blocks,
                normal,
                choice,
                frame.full,
                frame.noise_m,
                frame.coverage_deg,
                passed,
            )
    return FitFailure(f"the surface needed to settle within {MOST_PASSES} passes, it did not")


def _choose(profile: Profile, cells: Cells, frame: _Frame) -> tuple[Choice, Profile, Cells]:
    """Fit the fullest form to the cells, and drop what the data do not ask for."""
    full = frame.full
    values = np.zeros(full.size)
    values[kept_in(profile.form, full)] = profile.values_m
    fullest, cells, blocks, normal = _on_cells(Profile(full, values, profile.origin_m), cells, frame.task)
    wall_m2 = 0.0
    if frame.coverage_deg >= FULL_COVERAGE_DEG:
        wall_m2 = wall_variance(Weighed(cells, blocks.share, normal.poses), full, fullest.values_m)
    choice = choose_form(full, fullest.values_m, normal, Evidence(_independent(normal), wall_m2))
    places = kept_in(choice.kept, full)
    dropped = np.setdiff1d(np.arange(full.size), places)
    off = design(full, cells.foot_m, cells.direction)[:, dropped] @ fullest.values_m[dropped]
    return (
        choice,
        Profile(choice.kept, fullest.values_m[places], profile.origin_m),
        cells.moved(-off),
    )


def _on_cells(profile: Profile, cells: Cells, task: SurfaceTask) -> tuple[Profile, Cells, Blocks, Normal]:
    """Adjust a surface and the weights of the blocks by turns, on cells alone."""
    poses = _pose_terms(cells, profile, task)
    normal = normal_of(Weighed(cells, np.ones(len(cells.weight)), poses), profile.form, profile.values_m)
    for _ in range(MOST_STEPS):
        freed = cells.moved(cells.residual_m - normal.without_poses(cells.residual_m))
        blocks = weigh_blocks(freed, HEIGHTS_OF_BLOCK, profile.form.size)
        weighed = Weighed(cells, blocks.share, poses)
        normal = normal_with(weighed, normal.design, profile.form, profile.values_m)
        step = normal.step()
        profile = profile.moved(step)
        cells = cells.moved(normal.design @ step)
        if _is_small(step, profile, normal, 0.1 * SETTLED_SIGMAS):
            break
    return profile, cells, blocks, normal


def _pose_terms(cells: Cells, profile: Profile, task: SurfaceTask) -> NDArray[np.float64]:
    """How the poses move the cells (c, r); nothing moves them where no poses are known."""
    if task.poses is None:
        return np.zeros((len(cells.weight), 0))
    return by_pose_factors(cells, by_own_pose(cells, profile, task.poses), task.poses.factor())


def _independent(normal: Normal) -> float:
    """Number of independent observations: the information of all cells over that of the best one's points, at least 2."""
    return float(normal.weight.sum() / normal.weight.max())


def _holds(change_m: NDArray[np.float64], profile: Profile, normal: Normal) -> bool:
    """Whether a change leaves the axis where it is, whatever it does to radii and harmonics."""
    axis = np.arange(len(change_m)) < 2 * profile.form.n_axis
    return _is_small(np.where(axis, change_m, 0.0), profile, normal, NEAR_SIGMAS)


def _is_small(change_m: NDArray[np.float64], profile: Profile, normal: Normal, share: float) -> bool:
    """Whether a change of the coefficients is below that share of their standard deviations, or of no account at all."""
    sigma = np.sqrt(np.maximum(np.diag(np.linalg.inv(normal.matrix)), 0.0))
    nothing_m = NOTHING_RADII * mean_radius_m(profile.form, profile.values_m)
    return bool((np.abs(change_m) <= np.maximum(share * sigma, nothing_m)).all())
