"""Tests of differences of several components: exact for two, calibrated, and with the power they state."""

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.change import chi_square_test, detectable_factor
from tasks.geometry.plane_vectors import DETECTABLE_FACTOR

C = np.array([[4.0, 1.0], [1.0, 9.0]])


def test_two_components_follow_the_closed_form() -> None:
    d = np.array([3.0, -2.0])
    found = chi_square_test(d, C)
    assert found is not None
    assert found.statistic == pytest.approx(d @ np.linalg.solve(C, d))
    assert found.p_value == pytest.approx(np.exp(-found.statistic / 2.0), rel=1e-9)
    assert found.sigma == pytest.approx(np.sqrt(d @ C @ d) / np.linalg.norm(d))
    assert detectable_factor(2) == pytest.approx(DETECTABLE_FACTOR, abs=5e-5)


def test_published_detectable_change_of_two_epochs() -> None:
    # science.md 4: 4.39, 5.27 and 6.27 sigmas of an epoch at 5, 1 and 0.1 %, 80 % power
    for significance, sigmas in ((0.05, 4.39), (0.01, 5.27), (0.001, 6.27)):
        assert np.sqrt(2.0) * detectable_factor(2, significance) == pytest.approx(sigmas, abs=0.005)


def test_unit_and_turn_of_the_axes_do_not_matter() -> None:
    d, turn = np.array([3.0, -2.0]), np.array([[0.6, -0.8], [0.8, 0.6]])
    plain, other = chi_square_test(d, C), chi_square_test(1e3 * turn @ d, 1e6 * turn @ C @ turn.T)
    assert plain is not None
    assert other is not None
    assert other.statistic == pytest.approx(plain.statistic)
    assert other.size == pytest.approx(1e3 * plain.size)


@pytest.mark.parametrize("freedom", [2, 5])
def test_smallest_detectable_change_is_found_in_four_of_five_cases(freedom: int) -> None:
    rng = np.random.default_rng(1)
    moved = np.zeros(freedom)
    moved[0] = detectable_factor(freedom)
    draws = moved + rng.normal(size=(4000, freedom))
    found = [chi_square_test(d, np.eye(freedom)) for d in draws]
    assert np.mean([one is not None and one.significant for one in found]) == pytest.approx(0.8, abs=0.02)


@pytest.mark.parametrize(
    "covariance", [np.zeros((2, 2)), np.array([[1.0, 1.0], [1.0, 1.0]]), np.diag([1.0, -1.0])]
)
def test_singular_covariance_tests_nothing(covariance: np.ndarray) -> None:
    assert chi_square_test(np.array([1.0, 2.0]), covariance) is None


def test_wrong_shapes_and_values_are_refused() -> None:
    for d, covariance in ((np.ones(3), C), (np.array([np.nan, 1.0]), C)):
        with pytest.raises(ShapeError, match="needs a finite difference"):
            chi_square_test(d, covariance)
