import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from storage.errors import ShapeError
from storage.records import AccuracyRow
from tasks.accuracy import (
    QUANTITIES,
    Control,
    accuracy_rows,
    control_of_lean,
    control_of_scheme,
    cut_off,
    relative_error_pct,
)
from tasks.geometry.failure import FitFailure
from tasks.tilt import tilt_parameters
from tests.unit.accuracy.tilt_rows import tilt_row

A, F = tilt_row("A", np.array([0.0100, 0.0])), tilt_row("F", np.array([0.0, 0.0080]))


def control() -> Control:
    found = control_of_scheme([A, F], "F", "paper")
    assert isinstance(found, Control)
    return found


def of(rows: list[AccuracyRow], quantity: str) -> AccuracyRow:
    return next(row for row in rows if row.quantity == quantity)


def test_every_scheme_but_the_control_is_compared_in_every_quantity() -> None:
    rows = accuracy_rows([A, F], control())
    assert [(row.scheme, row.control, row.quantity) for row in rows] == [
        ("A", "F/paper", q) for q in QUANTITIES
    ]


def test_relative_error_is_that_of_the_value_against_the_control() -> None:
    row = of(accuracy_rows([A, F], control()), "deviation_m")
    assert (row.value, row.reference) == (A.deviation_m, F.deviation_m)
    assert row.difference == pytest.approx(102 * 0.002, abs=1e-12)
    assert row.relative_error_pct == pytest.approx(25.0, abs=1e-9)


def test_azimuth_has_a_difference_and_no_relative_error() -> None:
    row = of(accuracy_rows([A, F], control()), "azimuth_deg")
    assert row.difference == pytest.approx(90.0, abs=1e-9)
    assert row.relative_error_pct is None


@pytest.mark.parametrize(
    ("value_deg", "reference_deg", "expected_deg"), [(359.0, 1.0, -2.0), (1.0, 359.0, 2.0)]
)
def test_azimuths_are_compared_by_the_shorter_way_round(
    value_deg: float, reference_deg: float, expected_deg: float
) -> None:
    def lean(azimuth_deg: float) -> np.ndarray:
        return 0.01 * np.array([np.sin(np.radians(azimuth_deg)), np.cos(np.radians(azimuth_deg))])

    reference = control_of_lean("total station", lean(reference_deg), 102.0)
    row = of(accuracy_rows([tilt_row("A", lean(value_deg))], reference), "azimuth_deg")
    assert row.difference == pytest.approx(expected_deg, abs=1e-9)


def test_a_plumb_axis_has_no_azimuth_row() -> None:
    rows = accuracy_rows([tilt_row("A", np.zeros(2))], control())
    assert [row.quantity for row in rows] == [q for q in QUANTITIES if q != "azimuth_deg"]


def test_a_control_of_exactly_zero_has_differences_and_no_relative_errors() -> None:
    plumb = control_of_lean("total station", np.zeros(2), 102.0)
    row = of(accuracy_rows([A], plumb), "deviation_m")
    assert row.difference == pytest.approx(1.02, abs=1e-12)
    assert row.relative_error_pct is None


def test_same_scheme_by_another_method_is_compared_with_the_control_too() -> None:
    robust = tilt_row("F", np.array([0.0, 0.0080]), method="robust")
    assert {(row.scheme, row.method) for row in accuracy_rows([robust, F], control())} == {("F", "robust")}


def test_missing_control_is_a_failure_that_names_the_schemes_with_an_axis() -> None:
    found = control_of_scheme([A], "F", "paper")
    assert found == FitFailure("the control F/paper has no axis in this epoch; those that have one: A/paper")


def test_rows_of_two_epochs_are_refused() -> None:
    with pytest.raises(
        ShapeError, match="one structure and epoch; got chimney-01 2025-03, chimney-01 2026-03"
    ):
        accuracy_rows([A, tilt_row("A", np.array([0.01, 0.0]), epoch="2026-03")], control())


components = st.floats(-0.3, 0.3)


@given(components, components)
def test_control_of_a_lean_agrees_with_the_tilt_stage(east: float, north: float) -> None:
    lean = np.array([east, north])
    here, there = control_of_lean("total station", lean, 102.0), tilt_parameters(lean, None, 102.0)
    for quantity in QUANTITIES:
        assert getattr(here, quantity) == pytest.approx(getattr(there, quantity), abs=1e-11)


def test_control_with_sigma_has_the_sigmas_and_the_azimuth_of_the_tilt_stage() -> None:
    lean, sigma = np.array([0.003, -0.004]), 1e-4
    here = control_of_lean("total station", lean, 102.0, sigma)
    there = tilt_parameters(lean, sigma**2 * np.eye(2), 102.0)
    for name in ("azimuth_deg", "azimuth_sigma_deg", "tilt_sigma_deg", "deviation_sigma_m"):
        assert getattr(here, name) == pytest.approx(getattr(there, name)), name
    assert of(accuracy_rows([A], here), "verticality_permille").reference_sigma == pytest.approx(0.1)
    assert of(accuracy_rows([A], here), "beta_deg").reference_sigma is None


def test_control_below_three_sigmas_has_no_azimuth_to_compare_with() -> None:
    weak = control_of_lean("plumb line", np.array([2e-4, 0.0]), 102.0, 1e-4)
    assert "azimuth_deg" not in {row.quantity for row in accuracy_rows([A], weak)}


def test_control_of_a_lean_without_a_positive_sigma_is_refused() -> None:
    with pytest.raises(ShapeError, match="needs sigma above 0; got 0"):
        control_of_lean("total station", np.ones(2), 102.0, 0.0)


def test_control_of_a_lean_of_three_numbers_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"lean vector \(2,\)"):
        control_of_lean("total station", np.zeros(3), 102.0)


@given(st.floats(0.1, 1e3), st.floats(0.1, 1e3))
def test_relative_error_is_never_negative(value: float, reference: float) -> None:
    error = relative_error_pct(value, reference)
    assert isinstance(error, float)
    assert error >= 0.0


def test_relative_error_against_zero_is_a_failure() -> None:
    assert isinstance(relative_error_pct(1.0, 0.0), FitFailure)


@pytest.mark.parametrize(("value", "cut"), [(9.6063, 9.60), (6.7192, 6.71), (-1.239, -1.23)])
def test_cutting_off_does_not_round(value: float, cut: float) -> None:
    assert cut_off(value, 2) == cut
