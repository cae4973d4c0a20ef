import numpy as np
import pytest

from storage.errors import ShapeError
from tasks.trend import LeanSeries

TIMES = np.array([0.0, 1.0, 2.5])
MOVED = np.zeros((3, 2))
COVARIANCES = np.tile(1e-6 * np.eye(2), (3, 1, 1))


def test_descending_times_are_refused() -> None:
    with pytest.raises(ShapeError, match="times that ascend"):
        LeanSeries(TIMES[::-1], MOVED, COVARIANCES)


def test_a_covariance_that_is_not_positive_definite_is_refused() -> None:
    with pytest.raises(ShapeError, match="positive definite"):
        LeanSeries(TIMES, MOVED, np.zeros((3, 2, 2)))


def test_shapes_that_disagree_are_named() -> None:
    with pytest.raises(ShapeError, match=r"\(3,\), \(2, 2\)"):
        LeanSeries(TIMES, MOVED[:2], COVARIANCES)


def test_values_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ShapeError, match="finite"):
        LeanSeries(TIMES, MOVED + np.nan, COVARIANCES)


def test_a_temperature_for_some_epochs_only_is_refused() -> None:
    with pytest.raises(ShapeError, match="3 temperatures"):
        LeanSeries(TIMES, MOVED, COVARIANCES, temperatures=np.array([10.0, 20.0]))
