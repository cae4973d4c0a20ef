"""The congruency test over the centres: silent where nothing moved, and right about where something did."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tasks.change import AxisError, Centres, compare_centres
from tasks.change.centres import CentreChange

Z = np.arange(2.5, 102.0, 1.0)
SIGMA_M = 1e-3
RIGID = AxisError(np.diag([8e-3, 8e-3, 7e-6, 7e-6]) ** 2, (2.0, 102.0))


def centres(moved_m: NDArray[np.float64], stated_m: float = SIGMA_M) -> Centres:
    covariances = np.tile(stated_m**2 * np.eye(2), (len(Z), 1, 1))
    return Centres(Z, np.array([7e-3, -5e-3]) * Z[:, None] + moved_m, covariances)


def compared(
    moved_m: NDArray[np.float64] | float, seed: int = 1, noise_m: float = SIGMA_M, rigid: bool = True
) -> CentreChange:
    rng = np.random.default_rng(seed)
    first, second = (noise_m * rng.normal(size=(len(Z), 2)) for _ in range(2))
    poses = rng.normal(size=4) * np.sqrt(np.diag(RIGID.covariance)) * rigid
    by_poses = poses[:2] + Z[:, None] * poses[2:]
    found = compare_centres(centres(first), centres(second + by_poses + moved_m), RIGID)
    assert found is not None
    return found


def test_false_alarms_are_as_stated() -> None:
    found = [compared(0.0, seed) for seed in range(400)]
    p_values = np.array([one.p_value for one in found])
    shapes = np.array([one.shape_p_value for one in found])
    # binomial: 0.05 +- 3 * 0.011; the two halves of the test share 5 %, and the search for places takes less than its own
    assert 0.01 < np.mean(p_values < 0.05) < 0.083
    assert np.mean(shapes < 0.05) == pytest.approx(0.05, abs=0.033)
    assert sum(one.place_p_value is not None for one in found) <= 8


def test_a_lean_within_the_poses_is_no_change_of_shape() -> None:
    found = compared(np.outer(Z, [1e-5, 0.0]))
    assert found.place_p_value is None
    assert found.shape_p_value is not None
    assert found.shape_p_value > 0.01


def test_a_part_that_moved_is_found_with_its_height_and_size() -> None:
    moved = np.where(((Z > 40.0) & (Z < 55.0))[:, None], np.array([0.004, -0.003]), 0.0)
    found = compared(moved)
    assert found.significant
    assert (found.z_low_m, found.z_high_m) == pytest.approx((40.5, 54.5), abs=2.0)
    assert found.moved_m == pytest.approx(0.005, rel=0.2)
    assert found.noise_factor < 1.3


@pytest.mark.parametrize("factor", [1.05, 1.2, 1.5, 3.0])
@pytest.mark.parametrize("m", [10, 27, 100])
def test_noise_that_is_stated_too_small_raises_no_alarm(factor: float, m: int) -> None:
    rng = np.random.default_rng(round(100 * factor) + m)
    found = []
    for _ in range(300):
        z_m = Z[:m]
        covariances = np.tile(SIGMA_M**2 * np.eye(2), (m, 1, 1))
        pair = [Centres(z_m, factor * SIGMA_M * rng.normal(size=(m, 2)), covariances) for _ in range(2)]
        one = compare_centres(pair[0], pair[1], RIGID)
        assert one is not None
        found.append(one)
    # binomial: 0.05 + 3 * 0.013
    assert np.mean([one.p_value < 0.05 for one in found]) <= 0.09
    assert np.mean([one.p_value < 0.01 for one in found]) <= 0.03


def test_only_heights_of_both_epochs_count() -> None:
    every, some = centres(np.zeros((len(Z), 2))), centres(np.zeros((len(Z), 2)))
    some = Centres(some.z_m[::2], some.center_m[::2], some.covariance_m2[::2])
    found = compare_centres(every, some, RIGID)
    assert found is not None
    assert found.n == len(Z[::2])
    few = Centres(Z[:3], every.center_m[:3], every.covariance_m2[:3])
    assert compare_centres(every, few, RIGID) is None


def test_turning_the_frame_turns_nothing_else() -> None:
    moved = np.where((Z > 60.0)[:, None], np.array([0.003, 0.0]), 0.0)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    rng = np.random.default_rng(5)
    noise = SIGMA_M * rng.normal(size=(2, len(Z), 2))
    plain = compare_centres(centres(noise[0]), centres(noise[1] + moved), RIGID)
    pair = (
        Centres(Z, one.center_m @ turn.T, one.covariance_m2)
        for one in (centres(noise[0]), centres(noise[1] + moved))
    )
    turned = compare_centres(*pair, RIGID)
    assert plain is not None
    assert turned is not None
    assert turned.statistic == pytest.approx(plain.statistic, rel=1e-9)
    assert (turned.z_low_m, turned.z_high_m) == (plain.z_low_m, plain.z_high_m)


def bent_by_poses(seed: int, known: int) -> CentreChange:
    """Two epochs of a straight shaft that poses bend; ``known`` terms of the axis are in the covariance that is given."""
    rng = np.random.default_rng(seed)
    error = AxisError(np.diag([8e-3, 8e-3, 7e-6, 7e-6, 1e-3, 1e-3, 1e-3, 1e-3]) ** 2, (2.0, 102.0))
    first, second = (SIGMA_M * rng.normal(size=(len(Z), 2)) for _ in range(2))
    by_poses = error.terms(Z) @ (rng.normal(size=8) * np.sqrt(np.diag(error.covariance)))
    given = AxisError(error.covariance[:known, :known], error.ends_m)
    found = compare_centres(centres(first), centres(second + by_poses), given)
    assert found is not None
    return found


def test_a_bend_that_poses_cause_is_no_change_of_shape() -> None:
    found = [bent_by_poses(seed, known=8) for seed in range(300)]
    # binomial: 0.05 +- 3 * 0.0126
    assert np.mean([one.p_value < 0.05 for one in found]) <= 0.088
    assert np.mean([(one.shape_p_value or 0.0) < 0.05 for one in found]) == pytest.approx(0.05, abs=0.038)
    # this test can fail: with the straight axis alone nearly all of them would be called bent
    without = [bent_by_poses(seed, known=4) for seed in range(20)]
    assert np.mean([(one.shape_p_value or 0.0) < 0.05 for one in without]) > 0.7
