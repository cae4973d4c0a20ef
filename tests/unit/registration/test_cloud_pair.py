from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.geometry.rotations import rotation_from_vector
from tasks.registration.cloud_evidence import knowledge
from tasks.registration.cloud_fit import fit, sampled
from tasks.registration.cloud_motion import RigidMotion
from tasks.registration.cloud_pair import register_pair
from tasks.registration.cloud_result import PairRegistration
from tasks.registration.cloud_surface import surface_of

NOISE = 0.01
TRUTH = RigidMotion(rotation_from_vector(np.array([0.4, -0.3, 1.2])), np.array([30.0, -12.0, 4.0]))


def yard(rng: np.random.Generator, n: int = 1000) -> NDArray[np.float64]:
    """A ground, two walls and a tank, with noise: 5 n points over 20 m."""
    angle = rng.uniform(0, 2 * np.pi, n)
    parts = (
        np.column_stack([rng.uniform(-10, 10, (2 * n, 2)), np.zeros(2 * n)]),
        np.column_stack([rng.uniform(-4, 8, n), np.full(n, 5.0), rng.uniform(0, 4, n)]),
        np.column_stack([np.full(n, -6.0), rng.uniform(-8, 2, n), rng.uniform(0, 3, n)]),
        np.column_stack([3 + 1.5 * np.cos(angle), -3 + 1.5 * np.sin(angle), rng.uniform(0, 5, n)]),
    )
    return np.vstack(parts) + NOISE * rng.normal(size=(5 * n, 3))


def bare_cylinder(rng: np.random.Generator) -> NDArray[np.float64]:
    angle, radius = rng.uniform(0, 2 * np.pi, 4000), 4.0 + 0.02 * rng.normal(size=4000)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0, 30, 4000)])


@cache
def clouds() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rng = np.random.default_rng(11)
    return yard(rng), TRUTH.inverse().to_fixed(yard(rng))


@cache
def registered() -> PairRegistration:
    return register_pair(*clouds())


def corners_apart(one: RigidMotion, other: RigidMotion) -> float:
    """Largest distance between where two motions put points at the ends of the moving yard."""
    ends = TRUTH.inverse().to_fixed(10.0 * np.array([[1.0, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]]))
    return float(np.max(np.linalg.norm(one.to_fixed(ends) - other.to_fixed(ends), axis=1)))


def test_a_yard_is_found_without_a_start_and_trusted() -> None:
    found = registered()
    assert found.reasons == ()
    assert found.state == "ok"
    # five standard deviations of a corner, 14 m out: 0.3 mm and 6e-5 rad
    assert corners_apart(found.T_fixed_moving, TRUTH) < 5e-3


def test_true_motion_lies_within_the_stated_covariance() -> None:
    found = registered()
    turn = found.rotation @ TRUTH.rotation.T
    vector = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    centre = clouds()[1].mean(axis=0)
    off = np.r_[vector, found.centre - TRUTH.to_fixed(centre[None])[0]]
    # chi-square of 6 exceeds 22.5 once in a thousand
    assert off @ np.linalg.solve(found.covariance, off) < 22.5


def test_moving_both_clouds_moves_the_result_with_them() -> None:
    fixed, moving = clouds()
    carried = RigidMotion(rotation_from_vector(np.array([-0.7, 0.2, 2.0])), np.array([500.0, 80.0, -9.0]))
    found = register_pair(carried.to_fixed(fixed), moving).T_fixed_moving
    back = carried.inverse()
    expected = RigidMotion(back.rotation @ found.rotation, back.to_fixed(found.translation[None])[0])
    # the fit stops at a hundredth of a formal sigma, and equal distances may choose another partner
    assert corners_apart(expected, registered().T_fixed_moving) < 2e-4


def test_a_thousandfold_scale_changes_nothing_but_the_lengths() -> None:
    fixed, moving = clouds()
    large, small = register_pair(1000.0 * fixed, 1000.0 * moving), registered()
    assert large.state == small.state
    # rounding of the products, carried through the iterations
    assert large.rotation == pytest.approx(small.rotation, abs=1e-6)
    assert large.translation == pytest.approx(1000.0 * small.translation, abs=0.02)
    assert large.overlap_fixed == pytest.approx(small.overlap_fixed, abs=1e-3)
    assert large.covariance[:3, :3] == pytest.approx(small.covariance[:3, :3], rel=1e-2, abs=1e-10)
    assert large.covariance[3:, 3:] == pytest.approx(1e6 * small.covariance[3:, 3:], rel=1e-2, abs=1e-3)


def test_swapped_clouds_give_the_inverse() -> None:
    fixed, moving = clouds()
    swapped = register_pair(moving, fixed)
    assert swapped.state == "ok"
    # both ways count alike, so only the stop of the iterations differs
    assert corners_apart(swapped.T_fixed_moving.inverse(), registered().T_fixed_moving) < 2e-4


@pytest.mark.slow
def test_the_same_clouds_give_the_same_bits() -> None:
    again = register_pair(*clouds())
    assert np.array_equal(again.rotation, registered().rotation)
    assert np.array_equal(again.covariance, registered().covariance)


def test_a_bare_cylinder_neither_turns_nor_slides_visibly() -> None:
    rng = np.random.default_rng(5)
    start = RigidMotion(np.eye(3), np.zeros(3))
    found = register_pair(bare_cylinder(rng), bare_cylinder(rng), start)
    assert found.state == "not trustworthy"
    assert found.observability is not None
    assert set(found.observability.unobservable) == {"rotation about z", "shift along z"}
    assert any("not observable" in reason for reason in found.reasons)
    # about z a radian and more: nothing is known
    assert np.sqrt(found.covariance[2, 2]) > 0.5
    assert np.sqrt(found.covariance[5, 5]) > 5.0


def test_a_box_that_fits_upside_down_is_not_trusted() -> None:
    rng = np.random.default_rng(6)
    box = rng.uniform(-1.0, 1.0, (5000, 3))
    side = rng.integers(3, size=5000)
    box[np.arange(5000), side] = np.sign(box[np.arange(5000), side])
    box = box * [3.0, 2.0, 1.0] + 0.005 * rng.normal(size=box.shape)
    found = register_pair(box[:2500], box[2500:])
    assert found.state == "not trustworthy"
    assert found.rival is not None
    assert any("another placement" in reason for reason in found.reasons)


def test_clouds_that_share_nothing_are_not_trusted() -> None:
    rng = np.random.default_rng(7)
    ball = rng.normal(size=(3000, 3))
    ball *= 3.0 / np.linalg.norm(ball, axis=1, keepdims=True)
    found = register_pair(clouds()[0], ball)
    assert found.state == "not trustworthy"
    assert any("matches the other" in reason for reason in found.reasons)


def test_shapeless_clouds_are_not_trusted() -> None:
    rng = np.random.default_rng(8)
    found = register_pair(rng.normal(size=(1000, 3)), rng.normal(size=(1000, 3)))
    assert found.state == "not trustworthy"
    assert found.reasons != ()


def test_points_on_a_line_say_that_nothing_was_fitted() -> None:
    line = np.column_stack([np.linspace(0.0, 9.0, 500), np.zeros(500), np.zeros(500)])
    found = register_pair(line, line)
    assert found.state == "not trustworthy"
    assert "nothing could be fitted" in found.reasons[0]
    assert np.all(np.isinf(np.diag(found.covariance)))


def test_too_few_points_are_refused() -> None:
    with pytest.raises(ShapeError, match="100 distinct moving points; got 1"):
        register_pair(clouds()[0], np.zeros((500, 3)))


def test_a_number_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ShapeError, match="finite fixed points"):
        register_pair(np.full((500, 3), np.nan), clouds()[1])


@pytest.mark.slow
def test_stated_sigma_matches_scatter_over_repeats() -> None:
    rng = np.random.default_rng(9)
    square = []
    for _ in range(24):
        pair = sampled(surface_of(yard(rng)), surface_of(yard(rng)), 3000)
        fitted = fit(pair, RigidMotion(np.eye(3), np.zeros(3)), (0.05, 0.05), 20)
        assert fitted is not None
        motion = fitted.motion
        off = np.r_[motion.rotation[[2, 0, 1], [1, 2, 0]], motion.translation]
        square.append(off @ np.linalg.solve(knowledge(pair, fitted).covariance, off))
    # 144 squares of unit variance: 12 % from chance, the rest for the estimate of the covariance itself
    assert np.mean(square) / 6.0 == pytest.approx(1.0, abs=0.4)
