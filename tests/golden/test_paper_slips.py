"""Where Zhou et al. 2025 (Buildings 15, 3046) contradict themselves: each slip asserted as a slip."""

import math

import numpy as np
import pytest

from storage.records import TiltRow
from tasks.accuracy import (
    comparison_table,
    cut_off,
    workload_factors,
)
from tasks.accuracy.control import Control
from tasks.tilt import (
    beta_deg,
    lean_of_direction,
)
from tests.golden.paper_values import (
    DEVIATION_M,
    HEIGHT_M,
    MEAN_DEVIATION_MM,
    PROPOSED,
    RELATIVE_ERROR_PCT,
    RMSE_MM,
    SHAFT_M,
    SLICES,
    TILT_ARCSEC,
    VERTICALITY_PERMILLE,
    error_pct,
    mean_of,
    paper_control,
    paper_rows,
    vector,
)


@pytest.fixture(scope="module")
def rows() -> list[TiltRow]:
    return paper_rows()


@pytest.fixture(scope="module")
def control(rows: list[TiltRow]) -> Control:
    return paper_control(rows)


def test_slip_residuals_of_scheme_a_are_too_one_sided_for_the_scatter_of_single_centres() -> None:
    rng = np.random.default_rng(1)
    residuals = np.hypot(*rng.normal(size=(2, 4000, 101)))
    ratios = residuals.mean(axis=1) / np.sqrt((residuals**2).mean(axis=1))
    printed = MEAN_DEVIATION_MM["A"] / RMSE_MM["A"]
    assert (ratios.mean() - printed) / ratios.std() > 3.5


def test_slip_printed_mean_tilt_is_ten_seconds_too_large(rows: list[TiltRow], control: Control) -> None:
    printed_mean_arcsec = 34 * 60 + 45
    assert mean_of(TILT_ARCSEC) == pytest.approx(2075.4, abs=1e-9)
    mean_deg = comparison_table(rows, control).comparison("tilt_deg").mean
    assert mean_deg is not None
    assert mean_deg * 3600 == pytest.approx(2075.471, abs=1e-3)
    assert printed_mean_arcsec - mean_of(TILT_ARCSEC) == pytest.approx(9.6, abs=1e-9)


def test_slip_headline_of_9_45_percent_comes_from_the_wrong_mean_and_should_be_8_94(
    rows: list[TiltRow], control: Control
) -> None:
    assert round(error_pct(34 * 60 + 45, TILT_ARCSEC["F"]), 2) == 9.45
    assert error_pct(mean_of(TILT_ARCSEC), TILT_ARCSEC["F"]) == pytest.approx(8.945, abs=0.5e-3)
    assert mean_of(RELATIVE_ERROR_PCT) == pytest.approx(8.940, abs=1e-9)
    mean_errors = comparison_table(rows, control)
    assert mean_errors.comparison("deviation_m").mean_error_pct == pytest.approx(8.976, abs=0.5e-3)


def test_slip_headline_was_rounded_where_its_parts_were_cut_off() -> None:
    assert cut_off(error_pct(34 * 60 + 45, TILT_ARCSEC["F"]), 2) == 9.44


@pytest.mark.parametrize(
    ("printed", "own_errors"),
    [
        (VERTICALITY_PERMILLE, {"A": 10.18, "B": 9.64, "C": 9.86, "D": 8.56, "E": 6.83}),
        (DEVIATION_M, {"A": 10.18, "B": 9.63, "C": 9.86, "D": 8.55, "E": 6.82}),
    ],
)
def test_slip_relative_errors_of_verticality_and_deviation_are_copies_of_those_of_tilt(
    printed: dict[str, float], own_errors: dict[str, float]
) -> None:
    for scheme in PROPOSED:
        error = error_pct(printed[scheme], printed["F"])
        assert error == pytest.approx(own_errors[scheme], abs=0.0051)
        assert cut_off(error, 2) != RELATIVE_ERROR_PCT[scheme]


@pytest.mark.parametrize(
    ("scheme", "expected_pct"), [("A", 10.145), ("B", 9.652), ("C", 9.805), ("D", 8.525), ("E", 6.754)]
)
def test_relative_errors_of_the_deviation_from_the_vectors(
    rows: list[TiltRow], control: Control, scheme: str, expected_pct: float
) -> None:
    table = comparison_table(rows, control)
    error = table.comparison("deviation_m").errors_pct[table.schemes.index(scheme)]
    assert error == pytest.approx(expected_pct, abs=0.5e-3)


def test_slip_mean_errors_of_verticality_and_deviation_are_9_01_percent_from_the_printed_values() -> None:
    assert error_pct(mean_of(VERTICALITY_PERMILLE), VERTICALITY_PERMILLE["F"]) == pytest.approx(
        9.014, abs=0.5e-3
    )
    assert error_pct(mean_of(DEVIATION_M), DEVIATION_M["F"]) == pytest.approx(9.007, abs=0.5e-3)


def test_slip_eq_19_cannot_tell_opposite_leans_apart_by_more_than_1_3_percent() -> None:
    lean = np.array([math.tan(math.radians(0.58)), 0.0])
    east, west = (beta_deg(np.array([*side, 1.0])) for side in (lean, -lean))
    # 1.16 of about 90 degrees, though the directions of lean are 180 degrees apart
    assert error_pct(west, east) < 1.3


@pytest.mark.parametrize(
    ("scheme", "direction_deg", "at_102_m_mm"),
    [("A", 5.560, 135.4), ("B", 5.350, 129.4), ("C", 5.439, 131.5), ("D", 4.905, 116.2), ("E", 4.338, 97.3)],
)
def test_slip_0_004_percent_of_azimuth_hides_degrees_and_more_than_the_allowable_deviation(
    rows: list[TiltRow], control: Control, scheme: str, direction_deg: float, at_102_m_mm: float
) -> None:
    table = comparison_table(rows, control)
    azimuth = table.comparison("azimuth_deg").differences[table.schemes.index(scheme)]
    assert azimuth == pytest.approx(direction_deg, abs=0.5e-3)
    apart = lean_of_direction(vector(scheme)) - lean_of_direction(vector("F"))
    apart_mm = 1000 * HEIGHT_M * float(np.hypot(*apart))
    assert apart_mm == pytest.approx(at_102_m_mm, abs=0.06)
    assert apart_mm > 60.5


@pytest.mark.parametrize("than", ["B", "C", "D", "E"])
def test_slip_91_slices_of_section_4_1_contradict_every_workload_factor_of_scheme_a(than: str) -> None:
    printed = {"B": 4.8, "C": 9.2, "D": 16.8, "E": 50.5}
    factors = {(f.scheme, f.than): f.factor for f in workload_factors(SLICES | {"A": 91})}
    assert abs(factors["A", than] - printed[than]) > 0.4


def test_slip_factor_4_8_of_scheme_c_in_section_5_is_that_of_scheme_b() -> None:
    factors = {(f.scheme, f.than): f.factor for f in workload_factors(SLICES)}
    assert round(factors["A", "B"], 1) == 4.8
    assert round(factors["A", "C"], 1) == 9.2


def test_slip_interval_of_10_m_for_scheme_d_in_section_5_would_give_11_slices_not_6() -> None:
    assert math.floor(SHAFT_M / 10.0) + 1 == SLICES["C"]
    assert math.floor(SHAFT_M / 20.0) + 1 == SLICES["D"]
