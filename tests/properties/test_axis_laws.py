"""Laws of slices, contours and axis that hold for any shaft."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tasks.axis import Axis, fit_axis
from tasks.contours import Contour, Section, fit_contour
from tasks.slicing import cut_slices, slice_heights, user_scheme

SEEDS = st.integers(0, 2**32 - 1)
ANGLES = st.floats(-np.pi, np.pi)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    seed=SEEDS,
    low=st.floats(-50.0, 50.0),
    length=st.floats(0.5, 200.0),
    interval=st.floats(0.2, 30.0),
    thickness=st.floats(0.01, 1.0),
)
def test_slices_lie_in_the_shaft_and_hold_exactly_their_points(
    seed: int, low: float, length: float, interval: float, thickness: float
) -> None:
    scheme = user_scheme("G", interval_m=interval, thickness_m=thickness)
    heights = slice_heights(scheme, (low, low + length))
    if thickness <= length:
        assert heights.size >= 1
    z = np.random.default_rng(seed).uniform(low - 1.0, low + length + 1.0, 500)
    for height, found in zip(heights, cut_slices(z, heights, thickness), strict=True):
        assert low - 1e-8 <= height - thickness / 2
        assert height + thickness / 2 <= low + length + 1e-8
        inside = np.abs(z - height) <= thickness / 2
        edge = np.abs(np.abs(z - height) - thickness / 2) < 1e-8
        member = np.zeros(500, dtype=bool)
        member[found] = True
        assert (member == inside)[~edge].all()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    seed=SEEDS,
    azimuth=ANGLES,
    east=st.floats(-1e6, 1e6),
    north=st.floats(-6e6, 6e6),
    scale=st.floats(0.01, 100.0),
    name=st.sampled_from(["kasa", "geometric_circle", "robust_circle"]),
)
def test_circle_follows_rigid_motion_and_scale(
    seed: int, azimuth: float, east: float, north: float, scale: float, name: str
) -> None:
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, 4.0, 120)
    radius = 1.0 + 0.005 * rng.standard_normal(120)
    xy = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    turn = np.array([[np.cos(azimuth), -np.sin(azimuth)], [np.sin(azimuth), np.cos(azimuth)]])
    shift = np.array([east, north])
    moved = scale * (xy @ turn.T) + shift
    before = fit_contour(name, Section(np.column_stack([xy, np.zeros(120)]), 0.0, 0.01))
    after = fit_contour(name, Section(np.column_stack([moved, np.zeros(120)]), 0.0, 0.01))
    assert isinstance(before, Contour)
    assert isinstance(after, Contour)
    expected = scale * turn @ [before.center_east_m, before.center_north_m] + shift
    # points at 6e6 m are rounded to 1e-9 m; the iteration ends within 1e-10 of a radius, Tukey's scale within 1e-6
    tolerance = 1e-8 + 1e-6 * scale
    assert np.abs(expected - [after.center_east_m, after.center_north_m]).max() < tolerance
    assert abs(after.radius_m - scale * before.radius_m) < tolerance


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    seed=SEEDS,
    m=st.integers(5, 40),
    azimuth=ANGLES,
    lean_east=st.floats(-0.2, 0.2),
    lean_north=st.floats(-0.2, 0.2),
    scale=st.floats(0.01, 1000.0),
)
def test_robust_line_follows_turns_scale_and_order(
    seed: int, m: int, azimuth: float, lean_east: float, lean_north: float, scale: float
) -> None:
    rng = np.random.default_rng(seed)
    z = np.sort(rng.uniform(0.0, 100.0, m))
    sigma = rng.uniform(0.002, 0.02, m)
    xy = z[:, None] * [lean_east, lean_north] + sigma[:, None] * rng.standard_normal((m, 2))
    covariances = np.eye(2) * (sigma**2)[:, None, None]
    turn = np.array([[np.cos(azimuth), -np.sin(azimuth)], [np.sin(azimuth), np.cos(azimuth)]])
    order = rng.permutation(m)
    before = fit_axis("robust_line", np.column_stack([xy, z]), covariances)
    after = fit_axis(
        "robust_line", scale * np.column_stack([xy @ turn.T, z])[order], scale**2 * covariances[order]
    )
    assert isinstance(before, Axis)
    assert isinstance(after, Axis)
    # a millionth of the sigma of the lean, which is 1e-5 or more
    assert np.abs(after.lean - turn @ before.lean).max() < 1e-9


@settings(max_examples=30, deadline=None, derandomize=True)
@given(seed=SEEDS, m=st.integers(2, 30), name=st.sampled_from(["irls", "robust_line"]))
def test_axis_rises_and_states_a_positive_covariance(seed: int, m: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    z = rng.permutation(np.linspace(1.0, 50.0, m))
    centres = np.column_stack([0.01 * rng.standard_normal((m, 2)), z])
    axis = fit_axis(name, centres, np.tile(1e-5 * np.eye(2), (m, 1, 1)))
    assert isinstance(axis, Axis)
    assert axis.direction[2] > 0.0
    assert np.linalg.eigvalsh(axis.lean_covariance).min() > 0.0
