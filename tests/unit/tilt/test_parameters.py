import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from storage.errors import ShapeError
from tasks.tilt import beta_deg, lean_of_direction, tilt_parameters, tilt_rad

SIGMA = 3e-5
ISOTROPIC = SIGMA**2 * np.eye(2)
SKEWED = np.array([[4.0e-9, 1.2e-9], [1.2e-9, 1.0e-9]])
components = st.floats(-0.3, 0.3)


def lean(east: float, north: float) -> NDArray[np.float64]:
    return np.array([east, north])


@given(components, components)
def test_direction_is_a_unit_vector_whose_lean_is_the_given_one(east: float, north: float) -> None:
    p = tilt_parameters(lean(east, north), None, 102.0)
    assert math.hypot(p.d_east, p.d_north, p.d_up) == pytest.approx(1.0, abs=1e-12)
    # the contract's tolerance for d_e / d_u
    assert p.d_east / p.d_up == pytest.approx(east, abs=1e-12)
    assert p.d_north / p.d_up == pytest.approx(north, abs=1e-12)


@given(components, components)
def test_derived_figures_agree_with_the_lean_vector_as_the_contract_demands(
    east: float, north: float
) -> None:
    p = tilt_parameters(lean(east, north), None, 102.0)
    assert p.deviation_m == pytest.approx(102.0 * math.hypot(east, north), abs=1e-9)
    assert p.tilt_deg == pytest.approx(math.degrees(math.atan(math.hypot(east, north))), abs=1e-9)
    assert p.verticality_permille == pytest.approx(1000 * math.hypot(east, north), abs=1e-9)


@given(components, components)
def test_figures_agree_with_the_equations_of_the_paper(east: float, north: float) -> None:
    p = tilt_parameters(lean(east, north), None, 102.0)
    d = np.array([p.d_east, p.d_north, p.d_up])
    assert p.beta_deg == pytest.approx(beta_deg(d), abs=1e-12)
    # the horizontal part of d carries the rounding of 1
    assert p.tilt_deg == pytest.approx(math.degrees(tilt_rad(d)), abs=1e-12)


@pytest.mark.parametrize(
    ("east", "north", "azimuth"),
    [(0.0, 0.01, 0.0), (0.01, 0.0, 90.0), (0.0, -0.01, 180.0), (-0.01, 0.0, 270.0), (-0.01, 0.01, 315.0)],
)
def test_azimuth_runs_clockwise_from_north(east: float, north: float, azimuth: float) -> None:
    assert tilt_parameters(lean(east, north), ISOTROPIC, 102.0).azimuth_deg == pytest.approx(
        azimuth, abs=1e-9
    )


def test_azimuth_stays_below_360_just_west_of_north() -> None:
    azimuth = tilt_parameters(lean(-1e-20, 0.01), None, 102.0).azimuth_deg
    assert azimuth is not None
    assert 0.0 <= azimuth < 360.0


def test_exactly_vertical_axis_has_no_azimuth_even_without_covariance() -> None:
    p = tilt_parameters(lean(0.0, 0.0), None, 102.0)
    assert (p.azimuth_deg, p.azimuth_sigma_deg, p.tilt_deg, p.deviation_m) == (None, None, 0.0, 0.0)


def test_lean_below_three_sigma_has_no_azimuth() -> None:
    assert tilt_parameters(lean(2.99 * SIGMA, 0.0), ISOTROPIC, 102.0).azimuth_deg is None
    assert tilt_parameters(lean(3.01 * SIGMA, 0.0), ISOTROPIC, 102.0).azimuth_deg == pytest.approx(
        90.0, abs=1e-9
    )


def test_lean_that_is_significant_along_but_not_across_has_no_azimuth() -> None:
    narrow = np.diag([1e-12, 1e-8])
    assert tilt_parameters(lean(2e-4, 0.0), narrow, 102.0).azimuth_deg is None


def test_sigma_of_a_lean_below_three_sigma_is_that_of_its_least_certain_component() -> None:
    worst = math.sqrt(np.linalg.eigvalsh(SKEWED)[-1])
    for east in (0.0, 1e-6):
        p = tilt_parameters(lean(east, 0.0), SKEWED, 102.0)
        assert p.deviation_sigma_m == pytest.approx(102.0 * worst, rel=1e-9)
        assert p.tilt_sigma_deg == pytest.approx(math.degrees(worst), rel=1e-9)


def test_sigmas_are_missing_without_covariance() -> None:
    p = tilt_parameters(lean(0.01, 0.0), None, 102.0)
    assert (p.tilt_sigma_deg, p.azimuth_sigma_deg, p.deviation_sigma_m) == (None, None, None)
    assert p.azimuth_deg == pytest.approx(90.0, abs=1e-12)


def test_stated_sigmas_match_the_scatter_over_repeats() -> None:
    rng = np.random.default_rng(3)
    true = lean(0.2, -0.1)
    stated = tilt_parameters(true, SKEWED, 102.0)
    found = [tilt_parameters(x, None, 102.0) for x in rng.multivariate_normal(true, SKEWED, size=4000)]
    # a standard deviation from 4000 repeats is known to 1.1 %
    assert np.std([p.tilt_deg for p in found]) == pytest.approx(stated.tilt_sigma_deg, rel=0.04)
    assert np.std([p.azimuth_deg for p in found]) == pytest.approx(stated.azimuth_sigma_deg, rel=0.04)
    assert np.std([p.deviation_m for p in found]) == pytest.approx(stated.deviation_sigma_m, rel=0.04)


def test_sigmas_do_not_change_when_lean_and_covariance_turn_together() -> None:
    c, s = math.cos(1.1), math.sin(1.1)
    R = np.array([[c, -s], [s, c]])
    here = tilt_parameters(lean(0.01, 0.004), SKEWED, 102.0)
    turned = tilt_parameters(R @ lean(0.01, 0.004), R @ SKEWED @ R.T, 102.0)
    assert turned.tilt_sigma_deg == pytest.approx(here.tilt_sigma_deg, rel=1e-9)
    assert turned.azimuth_sigma_deg == pytest.approx(here.azimuth_sigma_deg, rel=1e-9)


@pytest.mark.parametrize(
    "covariance",
    [np.eye(3), np.array([[1.0, 0.5], [0.0, 1.0]]), np.diag([1.0, -1.0]), np.full((2, 2), np.nan)],
)
def test_a_covariance_that_is_none_is_refused(covariance: NDArray[np.float64]) -> None:
    with pytest.raises(ShapeError, match=r"tilt_parameters needs a .* covariance"):
        tilt_parameters(lean(0.01, 0.0), covariance, 102.0)


def test_a_rank_one_covariance_is_taken() -> None:
    p = tilt_parameters(lean(0.01, 0.0), np.outer([1e-5, 1e-5], [1e-5, 1e-5]), 102.0)
    assert p.deviation_sigma_m == pytest.approx(102.0 * 1e-5, rel=1e-9)


@pytest.mark.parametrize("height_m", [0.0, -1.0, math.inf])
def test_a_height_that_is_not_above_zero_is_refused(height_m: float) -> None:
    with pytest.raises(ShapeError, match=r"height_m above 0"):
        tilt_parameters(lean(0.01, 0.0), None, height_m)


def test_a_lean_of_three_numbers_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"lean vector \(2,\)"):
        tilt_parameters(np.zeros(3), None, 102.0)


def test_lean_of_a_direction_that_points_down_is_that_of_the_reversed_one() -> None:
    d = np.array([0.01, -0.02, 0.999])
    np.testing.assert_allclose(lean_of_direction(-d), lean_of_direction(d), rtol=1e-15)


def test_a_flat_direction_has_no_lean() -> None:
    with pytest.raises(ShapeError, match=r"not flat"):
        lean_of_direction(np.array([1.0, 0.0, 0.0]))
