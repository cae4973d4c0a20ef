"""What tables 1 to 3 of Zhou et al. 2025 (Buildings 15, 3046) say follows from the vectors they print.

Tolerances are half of the last printed digit unless a test says otherwise.
"""

import json
import math

import numpy as np
import pytest

from storage.records import TiltRow
from tasks.accuracy import (
    comparison_table,
    cut_off,
    fitting_table,
    slice_counts,
    workload_factors,
)
from tasks.accuracy.control import Control
from tasks.accuracy.grid_text import degrees_minutes_seconds
from tasks.limits import allowable, table_named
from tasks.tilt import (
    beta_deg,
    beta_of_reversed_axis_deg,
    deviation_m,
    lean_of_direction,
    tilt_parameters,
    tilt_rad,
    verticality,
)
from tests.golden.paper_values import (
    ARCSEC_DEG,
    AZIMUTH_ERROR_PCT,
    DEVIATION_M,
    HEIGHT_M,
    INTERVAL_M,
    PROPOSED,
    RELATIVE_ERROR_PCT,
    SCHEMES,
    SHAFT_M,
    SLICES,
    THICKNESS_M,
    TILT_ARCSEC,
    TRUE_AZIMUTH_DEG,
    VERTICALITY_PERMILLE,
    error_pct,
    mean_of,
    paper_control,
    paper_rows,
    printed_azimuth_deg,
    vector,
)
from tests.shared import SHARED, needs_shared


@pytest.fixture(scope="module")
def rows() -> list[TiltRow]:
    return paper_rows()


@pytest.fixture(scope="module")
def control(rows: list[TiltRow]) -> Control:
    return paper_control(rows)


# --- table 2: what is reproduced


@pytest.mark.parametrize("scheme", SCHEMES)
def test_printed_vectors_are_unit_vectors_within_what_truncated_digits_leave(scheme: str) -> None:
    # truncation of three components at 1e-8 can take off 1e-8 at most, and never adds
    assert -1e-8 < float(np.linalg.norm(vector(scheme))) - 1.0 <= 0.0


@pytest.mark.parametrize("scheme", SCHEMES)
def test_printed_azimuth_is_eq_19_of_the_reversed_vector(scheme: str) -> None:
    assert beta_of_reversed_axis_deg(vector(scheme)) == pytest.approx(
        printed_azimuth_deg(scheme), abs=0.5 * ARCSEC_DEG
    )


@pytest.mark.parametrize("scheme", SCHEMES)
def test_printed_azimuth_is_not_eq_19_of_the_printed_vector(scheme: str) -> None:
    assert abs(beta_deg(vector(scheme)) - printed_azimuth_deg(scheme)) == pytest.approx(0.84, abs=0.01)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_printed_tilt_follows_from_the_printed_vector(scheme: str) -> None:
    tilt_arcsec = math.degrees(tilt_rad(vector(scheme))) * 3600
    assert tilt_arcsec == pytest.approx(TILT_ARCSEC[scheme], abs=0.5)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_printed_verticality_follows_from_the_printed_vector(scheme: str) -> None:
    assert 1000 * verticality(tilt_rad(vector(scheme))) == pytest.approx(
        VERTICALITY_PERMILLE[scheme], abs=0.005
    )


@pytest.mark.parametrize("scheme", SCHEMES)
def test_printed_deviation_is_the_height_times_the_printed_rounded_verticality(scheme: str) -> None:
    exact = deviation_m(HEIGHT_M, VERTICALITY_PERMILLE[scheme] / 1000)
    # half of the last printed digit: 102 times 10.17 permille is 1.03734
    assert exact == pytest.approx(DEVIATION_M[scheme], abs=0.5e-4)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_unrounded_deviation_differs_from_the_printed_by_the_rounding_of_the_verticality(scheme: str) -> None:
    # 0.005 permille of 102 m is 0.51 mm, and the last digit adds 0.05 mm
    found = tilt_parameters(lean_of_direction(vector(scheme)), None, HEIGHT_M)
    assert found.deviation_m == pytest.approx(DEVIATION_M[scheme], abs=0.56e-3)


@pytest.mark.parametrize(("scheme", "expected"), TRUE_AZIMUTH_DEG.items())
def test_direction_of_lean_of_the_printed_vectors(scheme: str, expected: float) -> None:
    found = tilt_parameters(lean_of_direction(vector(scheme)), None, HEIGHT_M)
    # the six decimals to which the expected values are given
    assert found.azimuth_deg == pytest.approx(expected, abs=0.6e-6)


# --- table 1


def test_means_of_table_1(rows: list[TiltRow]) -> None:
    table = fitting_table(rows)
    assert table.mean_mean_deviation_m == pytest.approx(0.0121, abs=0.5e-4)
    assert table.mean_rmse_m == pytest.approx(0.0147, abs=0.5e-4)


@pytest.mark.parametrize(
    ("printed", "numerator", "slices"), [(21.8, 22, 101), (19.0, 4, 21), (27.3, 3, 11), (33.3, 2, 6)]
)
def test_update_weight_ratio_is_a_count_of_centres_and_only_one_count_fits(
    printed: float, numerator: int, slices: int
) -> None:
    assert [k for k in range(slices + 1) if round(100 * k / slices, 1) == printed] == [numerator]


def test_no_count_of_91_centres_gives_the_update_weight_ratio_of_scheme_a() -> None:
    assert [k for k in range(92) if round(100 * k / 91, 1) == 21.8] == []


# --- table 3: what is reproduced


@pytest.mark.parametrize("scheme", PROPOSED)
def test_printed_relative_error_of_tilt_is_cut_off_and_not_rounded(scheme: str) -> None:
    error = error_pct(TILT_ARCSEC[scheme], TILT_ARCSEC["F"])
    assert cut_off(error, 2) == RELATIVE_ERROR_PCT[scheme]


def test_rounding_would_not_give_the_printed_relative_errors_of_tilt() -> None:
    rounded = {s: round(error_pct(TILT_ARCSEC[s], TILT_ARCSEC["F"]), 2) for s in PROPOSED}
    assert [s for s in PROPOSED if rounded[s] != RELATIVE_ERROR_PCT[s]] == ["B", "E"]


@pytest.mark.parametrize("scheme", PROPOSED)
def test_printed_relative_error_of_azimuth_is_that_of_an_angle_near_90_degrees(scheme: str) -> None:
    error = error_pct(printed_azimuth_deg(scheme), printed_azimuth_deg("F"))
    assert error == pytest.approx(AZIMUTH_ERROR_PCT[scheme], abs=0.5e-3)


def test_mean_azimuth_of_table_3() -> None:
    mean_deg = sum(printed_azimuth_deg(scheme) for scheme in PROPOSED) / 5
    assert degrees_minutes_seconds(mean_deg) == "90°25'10\""
    assert error_pct(mean_deg, printed_azimuth_deg("F")) == pytest.approx(0.004, abs=0.5e-3)


def test_mean_verticality_and_deviation_of_table_3(rows: list[TiltRow], control: Control) -> None:
    assert mean_of(VERTICALITY_PERMILLE) == pytest.approx(10.06, abs=0.005)
    assert mean_of(DEVIATION_M) == pytest.approx(1.0263, abs=1e-12)
    table = comparison_table(rows, control)
    assert table.comparison("verticality_permille").mean == pytest.approx(10.062505, abs=1e-6)
    assert table.comparison("deviation_m").mean == pytest.approx(1.026376, abs=1e-6)


def test_allowable_deviation_at_102_m() -> None:
    limit_m = allowable(table_named("gb50078-concrete-quoted"), HEIGHT_M)
    assert limit_m == pytest.approx(0.0605, abs=1e-15)
    assert isinstance(limit_m, float)
    assert mean_of(DEVIATION_M) / limit_m == pytest.approx(16.96, abs=0.005)


# --- slices and workload


@pytest.mark.parametrize(("scheme", "interval_m"), INTERVAL_M.items())
def test_slice_counts_fit_a_shaft_of_100_01_m(scheme: str, interval_m: float) -> None:
    # first and last slice end with the shaft; the small term keeps 100.0/1.0 from falling below itself
    assert math.floor((SHAFT_M - THICKNESS_M) / interval_m + 1e-9) + 1 == SLICES[scheme]
    assert math.floor(SHAFT_M / interval_m) + 1 == SLICES[scheme]


@pytest.mark.parametrize(
    ("scheme", "than", "printed"),
    [
        ("A", "B", 4.8),
        ("A", "C", 9.2),
        ("A", "D", 16.8),
        ("A", "E", 50.5),
        ("A", "F", 50.5),
        ("B", "C", 1.9),
        ("B", "D", 3.5),
        ("B", "E", 10.5),
        ("C", "D", 1.8),
        ("C", "E", 5.5),
        ("D", "E", 3.0),
    ],
)
def test_workload_factors_of_section_4_2(rows: list[TiltRow], scheme: str, than: str, printed: float) -> None:
    factors = {(f.scheme, f.than): f.factor for f in workload_factors(slice_counts(rows))}
    assert factors[scheme, than] == pytest.approx(printed, abs=0.05)


# --- the same against the machine-readable list


@needs_shared
@pytest.mark.parametrize("scheme", SCHEMES)
def test_expected_values_of_the_list_come_out_of_the_printed_vectors(scheme: str) -> None:
    expected = json.loads((SHARED / "reference" / "paper_table2_expected.json").read_text(encoding="utf-8"))[
        scheme
    ]
    found = tilt_parameters(lean_of_direction(np.array(expected["vector"])), None, HEIGHT_M)
    # the list took arccos of a component, which eq. 19 of a not quite unit vector shifts by 4e-9 of 0.4 deg
    assert found.beta_deg == pytest.approx(expected["eq19_acos_Xd_deg"], abs=1e-6)
    assert 180.0 - found.beta_deg == pytest.approx(expected["eq19_acos_minus_Xd_deg"], abs=1e-6)
    assert found.tilt_deg == pytest.approx(expected["tilt_deg_atan2"], abs=1e-12)
    assert found.verticality_permille == pytest.approx(expected["verticality_permille"], abs=1e-9)
    assert found.deviation_m == pytest.approx(expected["deviation_m_unrounded"], abs=1e-12)
    assert found.azimuth_deg == pytest.approx(expected["true_azimuth_cw_from_y_deg"], abs=1e-9)


@needs_shared
def test_means_of_the_list_come_out_of_the_printed_vectors(rows: list[TiltRow], control: Control) -> None:
    means = json.loads((SHARED / "reference" / "paper_table2_expected.json").read_text(encoding="utf-8"))[
        "means"
    ]
    table = comparison_table(rows, control)
    found = {
        "tilt_arcsec_from_vectors": (table.comparison("tilt_deg").mean or 0.0) * 3600,
        "verticality_from_vectors": table.comparison("verticality_permille").mean,
        "deviation_from_vectors": table.comparison("deviation_m").mean,
        "RE_mean_deviation_vectors": table.comparison("deviation_m").mean_error_pct,
        "azimuth_from_printed_deg": sum(printed_azimuth_deg(s) for s in PROPOSED) / 5,
        "tilt_arcsec_from_printed": mean_of(TILT_ARCSEC),
        "RE_mean_tilt_correct": error_pct(mean_of(TILT_ARCSEC), TILT_ARCSEC["F"]),
        "RE_mean_tilt_paper_route": error_pct(34 * 60 + 45, TILT_ARCSEC["F"]),
    }
    assert found == pytest.approx({name: means[name] for name in found}, abs=1e-8)
