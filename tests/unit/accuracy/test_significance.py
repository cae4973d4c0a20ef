"""The test of a difference of lean vectors, and schemes over the epochs."""

import math

import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.accuracy import agreement, lean_difference

C = np.array([[4.0, 1.0], [1.0, 9.0]]) * 1e-10


def test_difference_of_three_sigmas_along_an_axis_has_the_probability_of_its_chi_square() -> None:
    found = lean_difference(np.array([3e-5, 0.0]), np.eye(2) * 1e-10)
    assert found.chi2 == pytest.approx(9.0)
    assert found.p_value == pytest.approx(math.exp(-4.5))
    assert found.significant is False
    assert lean_difference(np.array([3.1e-5, 0.0]), np.eye(2) * 1e-10).significant is True


def test_sigma_is_that_along_the_difference_and_the_largest_where_nothing_differs() -> None:
    assert lean_difference(np.array([1e-5, 0.0]), C).sigma == pytest.approx(2e-5)
    assert lean_difference(np.zeros(2), C).sigma == pytest.approx(math.sqrt(np.linalg.eigvalsh(C)[1]))


@pytest.mark.parametrize("covariance", [None, np.zeros((2, 2)), np.diag([1.0, 0.0]), np.diag([1.0, -1.0])])
def test_covariance_that_is_unknown_or_singular_tests_nothing(covariance: np.ndarray | None) -> None:
    found = lean_difference(np.array([1e-5, 0.0]), covariance)
    assert (found.chi2, found.p_value, found.significant, found.sigma) == (None, None, None, None)


@pytest.mark.parametrize(
    ("difference", "covariance"),
    [
        (np.zeros(3), None),
        (np.array([np.nan, 0.0]), None),
        (np.zeros(2), np.eye(3)),
        (np.zeros(2), np.full((2, 2), np.inf)),
    ],
)
def test_what_is_no_difference_is_refused(difference: np.ndarray, covariance: np.ndarray | None) -> None:
    with pytest.raises(ShapeError, match="lean_difference needs a finite"):
        lean_difference(difference, covariance)


def test_a_constant_bias_has_no_scatter() -> None:
    found = agreement([lean_difference(np.array([1e-4, -2e-4]), C)] * 3)
    assert (found.mean_east, found.mean_north) == pytest.approx((1e-4, -2e-4))
    assert found.scatter == pytest.approx(0.0, abs=1e-18)
    assert found.sigma == pytest.approx(math.sqrt(6.5e-10))


def test_scatter_over_many_epochs_is_that_of_one_component() -> None:
    rng = np.random.default_rng(4)
    d = rng.normal(1e-4, 2e-5, (3000, 2))
    found = agreement([lean_difference(one, np.eye(2) * 4e-10) for one in d])
    # 6000 numbers know a sigma to 1 %; three of these
    assert found.scatter == pytest.approx(2e-5, rel=0.03)
    assert found.sigma == pytest.approx(2e-5)


def test_epoch_without_stated_sigma_leaves_none_for_all() -> None:
    known, unknown = lean_difference(np.zeros(2), C), lean_difference(np.zeros(2), None)
    assert agreement([known, unknown]).sigma is None


def test_one_epoch_says_nothing_of_agreement() -> None:
    with pytest.raises(ShapeError, match="agreement needs the differences of at least 2 epochs; got 1"):
        agreement([lean_difference(np.zeros(2), C)])
