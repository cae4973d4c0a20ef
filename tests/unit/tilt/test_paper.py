import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.tilt import beta_deg, beta_of_reversed_axis_deg, deviation_m, tilt_rad, verticality

horizontal = st.floats(-0.5, 0.5)


def unit(east: float, north: float) -> NDArray[np.float64]:
    d = np.array([east, north, 1.0])
    return np.asarray(d / np.linalg.norm(d))


@given(horizontal, horizontal)
def test_beta_is_the_arccos_of_eq_19(east: float, north: float) -> None:
    d = unit(east, north)
    # arccos is well conditioned here: |d_east| stays below 0.45
    assert beta_deg(d) == pytest.approx(math.degrees(math.acos(d[0])), abs=1e-10)


@given(horizontal, horizontal)
def test_beta_of_the_reversed_axis_is_eq_19_of_minus_d(east: float, north: float) -> None:
    d = unit(east, north)
    assert beta_of_reversed_axis_deg(d) == pytest.approx(math.degrees(math.acos(-d[0])), abs=1e-10)


def test_beta_does_not_see_where_north_the_axis_leans() -> None:
    assert beta_deg(unit(0.003, 0.01)) == pytest.approx(beta_deg(unit(0.003, -0.01)), abs=1e-12)


@given(horizontal, horizontal)
def test_verticality_of_the_tilt_is_the_horizontal_over_the_vertical(east: float, north: float) -> None:
    assert verticality(tilt_rad(unit(east, north))) == pytest.approx(math.hypot(east, north), abs=1e-12)


def test_tilt_of_a_tiny_lean_is_exact_where_arccos_gives_zero() -> None:
    d = np.array([1e-9, 0.0, 1.0])
    assert math.acos(d[2] / np.linalg.norm(d)) == 0.0
    assert tilt_rad(d) == pytest.approx(1e-9, rel=1e-12)


def test_tilt_does_not_depend_on_the_length_of_the_direction() -> None:
    assert tilt_rad(np.array([3.0, 4.0, 500.0])) == pytest.approx(math.atan(0.01), rel=1e-12)


def test_deviation_is_the_height_times_the_verticality() -> None:
    assert deviation_m(102.0, 0.01) == pytest.approx(1.02, abs=1e-15)


@pytest.mark.parametrize("direction", [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, np.nan, 1.0], [0.0, 1.0]])
@pytest.mark.parametrize("equation", [beta_deg, tilt_rad, beta_of_reversed_axis_deg])
def test_a_direction_that_does_not_point_up_is_refused(
    equation: Callable[[NDArray[np.float64]], float], direction: list[float]
) -> None:
    with pytest.raises(ShapeError, match=r"finite direction \(3,\) with up above 0; got"):
        equation(np.array(direction))
