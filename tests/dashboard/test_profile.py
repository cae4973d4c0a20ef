"""The axis along the lean and across it."""

from dataclasses import replace

import numpy as np

from dashboard.content.direction import Direction, direction_of
from dashboard.content.profile import profile_of
from storage.records import AxisParameterRow, SliceRow
from tests.storage.campaign import STRUCTURE, slice_row, tilt_row

TILT = tilt_row("e0")
DIRECTION = direction_of(TILT)


def _on_axis(index: int, z_m: float, off: tuple[float, float] = (0.0, 0.0)) -> SliceRow:
    east = TILT.base_east_m + TILT.lean_east * z_m + off[0]
    north = TILT.base_north_m + TILT.lean_north * z_m + off[1]
    return replace(
        slice_row("e0", index),
        z_m=z_m,
        center_east_m=east,
        center_north_m=north,
        offset_east_m=off[0],
        offset_north_m=off[1],
        center_cov_ee=4e-6,
        center_cov_en=0.0,
        center_cov_nn=4e-6,
    )


def _parameter(name: str, value: float) -> AxisParameterRow:
    return AxisParameterRow(STRUCTURE, "e0", "A", "paper", name, 0, value, 1e-4)


def test_centres_on_the_axis_lie_on_the_line_along_the_lean_and_at_zero_across() -> None:
    profile = profile_of(TILT, [_on_axis(1, 60.0), _on_axis(0, 20.0)], [], DIRECTION, None)
    size = np.hypot(TILT.lean_east, TILT.lean_north)
    np.testing.assert_allclose(profile.z_m, [20.0, 60.0])
    np.testing.assert_allclose(profile.centres_m[:, 0], size * profile.z_m, atol=1e-12)
    np.testing.assert_allclose(profile.centres_m[:, 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(profile.residuals_m, 0.0, atol=1e-12)
    np.testing.assert_allclose(profile.sigmas_m, 2e-3)
    assert profile.curve_m is None


def test_a_slice_without_a_centre_is_left_out() -> None:
    failed = replace(slice_row("e0", 2), z_m=80.0, center_east_m=None, center_north_m=None, state="failed")
    profile = profile_of(TILT, [_on_axis(0, 20.0), failed], [], DIRECTION, None)
    assert profile.index.tolist() == [0]


def test_residuals_keep_their_sign() -> None:
    east = Direction(90.0, is_lean=True)
    profile = profile_of(
        TILT, [_on_axis(0, 20.0, (3e-3, 0.0)), _on_axis(1, 40.0, (-3e-3, 0.0))], [], east, None
    )
    np.testing.assert_allclose(profile.residuals_m[:, 0], [3e-3, -3e-3], atol=1e-15)


def test_a_bent_axis_is_off_the_straight_one_by_its_legendre_polynomial() -> None:
    slices = [_on_axis(index, z_m) for index, z_m in enumerate((0.0, 51.0, 102.0))]
    parameters = [_parameter("bend_east", 2e-3), _parameter("bend_north", 0.0)]
    profile = profile_of(TILT, slices, parameters, Direction(90.0, is_lean=True), None)
    assert profile.curve_m is not None
    off = (profile.curve_m - profile.line_m)[:, 0]
    # P2 is 1 at the ends and -1/2 in the middle
    np.testing.assert_allclose([off[0], off[51], off[-1]], [2e-3, -1e-3, 2e-3], atol=1e-9)


def test_unknown_covariances_and_offsets_stay_unknown() -> None:
    bare = replace(_on_axis(0, 20.0), center_cov_ee=None, offset_east_m=None, weight=None)
    profile = profile_of(TILT, [bare], [], DIRECTION, None)
    assert np.isnan(profile.sigmas_m).any()
    assert np.isnan(profile.residuals_m).any()
    assert np.isnan(profile.weights).all()


def test_the_bend_of_a_whole_surface_is_drawn_over_the_shaft_and_not_over_its_bands() -> None:
    surface = replace(TILT, scheme="S", method="surface")
    # the lowest and the highest band have their middle within the shaft
    slices = [_on_axis(index, z_m) for index, z_m in enumerate((2.0, 51.0, 80.0))]
    parameters = [_parameter("bend_east", 2e-3), _parameter("bend_north", 0.0)]
    east = Direction(90.0, is_lean=True)
    profile = profile_of(surface, slices, parameters, east, (0.0, 102.0))
    assert profile.curve_m is not None
    off = (profile.curve_m - profile.line_m)[:, 0]
    np.testing.assert_allclose([off[0], off[51], off[-1]], [2e-3, -1e-3, 2e-3], atol=1e-9)
    assert profile_of(surface, slices, parameters, east, None).curve_m is None
