"""What every axis estimator does, and what it refuses."""

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import InputError, ShapeError
from tasks.axis import AXES, Axis, fit_axis
from tasks.geometry.failure import FitFailure
from tests.unit.axis.shafts import LEAN, Shaft, shaft


def axis(name: str, data: Shaft) -> Axis:
    fit = fit_axis(name, data.centres_m, data.covariances_m2)
    assert isinstance(fit, Axis), fit
    return fit


def data_for(name: str, seed: int = 1, sigma_m: float = 0.01) -> Shaft:
    return shaft(np.random.default_rng(seed), 2 if name == "two_points" else 21, sigma_m)


@pytest.mark.parametrize("name", AXES)
def test_exact_centres_give_their_own_line(name: str) -> None:
    fit = axis(name, data_for(name, sigma_m=0.0))
    assert fit.lean == pytest.approx(LEAN, abs=1e-12)
    assert np.linalg.norm(fit.direction) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("name", AXES)
def test_point_lies_on_the_line(name: str) -> None:
    fit = axis(name, data_for(name, sigma_m=0.0))
    assert fit.point_m[:2] - fit.point_m[2] * LEAN == pytest.approx([0.0, 0.0], abs=1e-10)


@pytest.mark.parametrize("name", AXES)
def test_vertical_axis_is_fine(name: str) -> None:
    data = data_for(name, sigma_m=0.0)
    data.centres_m[:, :2] = 3.0
    fit = axis(name, data)
    assert fit.direction == pytest.approx([0.0, 0.0, 1.0], abs=1e-15)


@pytest.mark.parametrize("name", AXES)
def test_direction_points_up_whatever_the_order_of_the_centres(name: str) -> None:
    data = data_for(name)
    upside = axis(name, Shaft(data.centres_m[::-1].copy(), data.covariances_m2[::-1].copy()))
    assert upside.direction[2] > 0.0
    assert upside.lean == pytest.approx(axis(name, data).lean, abs=1e-10)


@pytest.mark.parametrize("name", AXES)
def test_weights_and_residuals_follow_the_order_of_the_centres(name: str) -> None:
    data = data_for(name)
    order = np.random.default_rng(2).permutation(len(data.centres_m))
    here, there = axis(name, data), axis(name, Shaft(data.centres_m[order], data.covariances_m2[order]))
    np.testing.assert_allclose(there.weights, here.weights[order], rtol=1e-6)
    if here.residuals_m is not None and there.residuals_m is not None:
        np.testing.assert_allclose(there.residuals_m, here.residuals_m[order], atol=1e-9)


@pytest.mark.parametrize("name", AXES)
def test_axis_turns_and_moves_with_the_centres(name: str) -> None:
    data = data_for(name)
    c, s = np.cos(2.0), np.sin(2.0)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    shift = np.array([500_000.0, 6_000_000.0, 100.0])
    plane = turn[:2, :2]
    moved = Shaft(data.centres_m @ turn.T + shift, plane @ data.covariances_m2 @ plane.T)
    here, there = axis(name, data), axis(name, moved)
    # coordinates of 6e6 m carry 1e-9 m, over 100 m
    assert there.lean == pytest.approx(plane @ here.lean, abs=1e-9)
    expected = plane @ here.lean_covariance @ plane.T
    np.testing.assert_allclose(there.lean_covariance, expected, rtol=1e-4, atol=1e-14)


@pytest.mark.parametrize("name", AXES)
def test_weights_end_at_one(name: str) -> None:
    fit = axis(name, data_for(name))
    assert fit.weights.max() == 1.0
    assert fit.weights.min() >= 0.0


@pytest.mark.parametrize("name", ["irls", "robust_line"])
def test_equation_18_is_unweighted_with_divisor_m(name: str) -> None:
    fit = axis(name, data_for(name))
    assert fit.residuals_m is not None
    assert fit.mean_deviation_m == pytest.approx(np.sum(fit.residuals_m) / 21, rel=1e-12)
    assert fit.rmse_m == pytest.approx(np.sqrt(np.sum(fit.residuals_m**2) / 21), rel=1e-12)


@pytest.mark.parametrize("name", ["irls", "robust_line"])
def test_bending_is_the_amplitude_of_the_parabola(name: str) -> None:
    fit = axis(name, shaft(np.random.default_rng(3), 41, 0.0, 0.01, bend_m=0.05))
    assert fit.bending_m == pytest.approx(0.05, rel=1e-6)


@pytest.mark.parametrize("name", ["irls", "robust_line"])
def test_three_centres_say_nothing_of_bending(name: str) -> None:
    assert axis(name, shaft(np.random.default_rng(4), 3)).bending_m is None
    assert axis(name, shaft(np.random.default_rng(4), 4)).bending_m is not None


@pytest.mark.parametrize("name", AXES)
def test_two_centres_leave_nothing_over(name: str) -> None:
    data = shaft(np.random.default_rng(5), 2)
    fit = axis(name, data)
    assert fit.residuals_m is None
    assert fit.rmse_m is None
    assert fit.mean_deviation_m is None
    np.testing.assert_allclose(fit.lean_covariance, data.covariances_m2.sum(axis=0) / 100.0**2, rtol=1e-12)


def altered(data: Shaft, row: int, column: int, value: float) -> NDArray[np.float64]:
    centres = data.centres_m.copy()
    centres[row, column] = value
    return centres


@pytest.mark.parametrize("name", AXES)
def test_fewer_than_two_centres_fail(name: str) -> None:
    for m in (0, 1):
        fit = fit_axis(name, np.zeros((m, 3)), np.zeros((m, 2, 2)))
        assert isinstance(fit, FitFailure)
        assert f"at least 2 centres, got {m}" in fit.reason


@pytest.mark.parametrize("name", AXES)
def test_centre_that_is_not_finite_fails(name: str) -> None:
    data = data_for(name)
    fit = fit_axis(name, altered(data, 1, 0, np.nan), data.covariances_m2)
    assert isinstance(fit, FitFailure)
    assert "got 1 of" in fit.reason


@pytest.mark.parametrize("name", AXES)
def test_covariance_with_a_negative_variance_fails(name: str) -> None:
    data = data_for(name)
    fit = fit_axis(name, data.centres_m, -data.covariances_m2)
    assert isinstance(fit, FitFailure)
    assert "negative variances" in fit.reason


@pytest.mark.parametrize("name", AXES)
def test_centres_at_one_height_fail(name: str) -> None:
    data = data_for(name)
    data.centres_m[:, 2] = 7.0
    fit = fit_axis(name, data.centres_m, data.covariances_m2)
    assert isinstance(fit, FitFailure)
    assert "different heights" in fit.reason


@pytest.mark.parametrize("name", AXES)
def test_axis_that_lies_down_fails(name: str) -> None:
    data = data_for(name)
    data.centres_m[:, 0] = 3.0 * data.centres_m[:, 2]
    fit = fit_axis(name, data.centres_m, data.covariances_m2)
    assert isinstance(fit, FitFailure)
    assert "within 60 deg of the vertical, got one at 71.6 deg" in fit.reason


def test_direct_line_through_three_centres_fails() -> None:
    data = shaft(np.random.default_rng(6), 3)
    fit = fit_axis("two_points", data.centres_m, data.covariances_m2)
    assert isinstance(fit, FitFailure)
    assert "exactly 2 centres, got 3" in fit.reason


def test_unknown_estimator_is_answered_with_the_known_ones() -> None:
    data = shaft(np.random.default_rng(7), 3)
    with pytest.raises(
        InputError, match=r"unknown axis estimator 'pca'; known: bent_axis, .*, robust_line, .*, two_points, "
    ):
        fit_axis("pca", data.centres_m, data.covariances_m2)


def test_arrays_that_do_not_fit_are_misuse() -> None:
    with pytest.raises(ShapeError, match=r"got \(4, 3\) and \(5, 2, 2\)"):
        fit_axis("irls", np.zeros((4, 3)), np.zeros((5, 2, 2)))
