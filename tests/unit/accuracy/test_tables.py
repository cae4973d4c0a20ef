import numpy as np
import pytest

from storage.errors import ShapeError
from storage.records import TiltRow
from tasks.accuracy import (
    RECOMMENDATIONS,
    Control,
    comparison_lines,
    comparison_table,
    control_of_lean,
    control_of_scheme,
    fitting_lines,
    fitting_table,
    monitoring_lines,
    monitoring_table,
    recommendation_lines,
    savings,
    slice_counts,
    workload_factors,
    workload_lines,
)
from tasks.accuracy.grid_text import Line, degrees_minutes_seconds, grid, number
from tests.unit.accuracy.tilt_rows import Fit, tilt_row

C = 9e-10 * np.eye(2)
SLICES = {"A": 101, "C": 11, "E": 2, "F": 2}


@pytest.fixture
def rows() -> list[TiltRow]:
    fits = {
        "A": Fit(101, 2, 0.0110, 0.0133, C),
        "C": Fit(11, 2, 0.0131, 0.0157, C),
        "E": Fit(2, covariance=C),
        "F": Fit(2),
    }
    leans = {"A": (0.0073, -0.0070), "C": (0.0073, -0.0069), "E": (0.0072, -0.0066), "F": (0.0072, -0.0057)}
    return [tilt_row(scheme, np.array(leans[scheme]), fit) for scheme, fit in fits.items()]


@pytest.fixture
def control(rows: list[TiltRow]) -> Control:
    found = control_of_scheme(rows, "F", "paper")
    assert isinstance(found, Control)
    return found


def test_means_of_the_fit_leave_out_schemes_without_the_figure(rows: list[TiltRow]) -> None:
    table = fitting_table(rows)
    assert table.mean_mean_deviation_m == pytest.approx((0.0110 + 0.0131) / 2, abs=1e-15)
    assert table.mean_rmse_m == pytest.approx((0.0133 + 0.0157) / 2, abs=1e-15)


def test_means_of_the_fit_of_direct_lines_alone_do_not_exist(rows: list[TiltRow]) -> None:
    assert fitting_table(rows[2:]).mean_rmse_m is None


def test_means_of_the_comparison_leave_out_the_control(rows: list[TiltRow], control: Control) -> None:
    table = comparison_table(rows, control)
    assert table.schemes == ("A", "C", "E")
    assert table.comparison("deviation_m").mean == pytest.approx(
        np.mean([r.deviation_m for r in rows[:3]]), abs=1e-15
    )


def test_mean_azimuth_is_taken_round_the_circle() -> None:
    leans = [np.array([-0.0001, 0.01]), np.array([0.0001, 0.01])]
    pair = [tilt_row(s, lean) for s, lean in zip("AB", leans, strict=True)]
    table = comparison_table(pair, control_of_lean("total station", np.array([0.0, 0.01]), 102.0))
    mean = table.comparison("azimuth_deg").mean
    assert mean is not None
    assert min(mean, 360.0 - mean) == pytest.approx(0.0, abs=1e-9)


def test_mean_of_opposite_azimuths_does_not_exist() -> None:
    pair = [tilt_row("A", np.array([0.01, 0.0])), tilt_row("B", np.array([-0.01, 0.0]))]
    table = comparison_table(pair, control_of_lean("total station", np.array([0.0, 0.01]), 102.0))
    assert table.comparison("azimuth_deg").mean is None
    assert table.comparison("azimuth_deg").mean_difference is None


def test_tables_refuse_rows_of_two_methods(rows: list[TiltRow]) -> None:
    with pytest.raises(ShapeError, match="rows of one method; got paper, robust"):
        monitoring_table([*rows, tilt_row("A", np.array([0.01, 0.0]), method="robust")])


def test_comparison_of_the_control_with_itself_is_refused(rows: list[TiltRow], control: Control) -> None:
    with pytest.raises(ShapeError, match="got no rows"):
        comparison_table(rows[3:], control)


def test_comparison_may_count_from_a_control_of_another_method(rows: list[TiltRow], control: Control) -> None:
    robust = [tilt_row("A", np.array([0.01, 0.0]), method="robust")]
    assert comparison_table(robust, control).control == "F/paper"
    assert comparison_table(robust, control).method == "robust"


def test_unknown_quantity_is_answered_with_the_known_ones(rows: list[TiltRow], control: Control) -> None:
    with pytest.raises(ShapeError, match="no quantity 'tilt'; it has beta_deg, azimuth_deg, tilt_deg"):
        comparison_table(rows, control).comparison("tilt")


def test_workload_factors_are_ratios_of_slices_and_all_above_one() -> None:
    factors = {(f.scheme, f.than): f.factor for f in workload_factors(SLICES | {"S": 0})}
    assert factors == {
        ("A", "C"): 101 / 11,
        ("A", "E"): 50.5,
        ("A", "F"): 50.5,
        ("C", "E"): 5.5,
        ("C", "F"): 5.5,
    }


def test_recommendation_has_the_three_cases_of_the_paper() -> None:
    assert [case.schemes for case in RECOMMENDATIONS] == [("A", "B"), ("C", "D"), ("E",)]


def test_savings_come_from_the_slices_that_were_cut() -> None:
    assert [(f.than, f.factor) for f in savings(RECOMMENDATIONS[1], SLICES | {"A": 99})] == [("C", 9.0)]


def test_savings_of_equal_schemes_do_not_exist() -> None:
    assert savings(RECOMMENDATIONS[2], {"E": 2, "F": 2}) == []
    assert workload_lines({"E": 2, "F": 2}) == []


@pytest.mark.parametrize(
    ("angle_deg", "text"),
    [
        (0.5827039520, "0°34'58\""),
        (90.4209673408, "90°25'15\""),
        (359.99999, "360°00'00\""),
        (0.99999, "1°00'00\""),
        (-5.5, "-5°30'00\""),
        (-1e-9, "0°00'00\""),
        (None, "--"),
    ],
)
def test_angles_are_written_to_the_nearest_second_with_the_carry_done(
    angle_deg: float | None, text: str
) -> None:
    assert degrees_minutes_seconds(angle_deg) == text


def test_missing_number_is_written_as_two_dashes_and_zero_as_zero() -> None:
    assert (number(None, 2), number(0.0, 2), number(0.0121, 1, 1e3)) == ("--", "0.00", "12.1")


def test_columns_of_a_grid_end_together() -> None:
    lines = grid("title", ["A", "mean"], [Line("short", ("1", "2")), Line("a longer label", ("100.0", "--"))])
    assert lines == [
        "title",
        "                    A  mean",
        "short               1     2",
        "a longer label  100.0    --",
    ]


def test_table_1_shows_dashes_for_the_direct_lines_and_names_its_own_definitions(rows: list[TiltRow]) -> None:
    text = fitting_lines(fitting_table(rows))
    shown = {line[:28].strip(): line[28:].split() for line in text[2:-1]}
    assert shown["centres in the fit"] == ["101", "11", "2", "2", "--"]
    assert shown["iterations"] == ["2", "2", "--", "--", "--"]
    assert shown["root mean square error (mm)"] == ["13.3", "15.7", "--", "--", "14.5"]
    assert "our definitions, the paper gives none" in text[-1]


def test_table_2_shows_the_figures_of_every_scheme_with_sigma(rows: list[TiltRow]) -> None:
    text = monitoring_lines(monitoring_table(rows))
    tilt = next(k for k, line in enumerate(text) if line.startswith("tilt"))
    assert text[tilt].split()[4:] == [degrees_minutes_seconds(row.tilt_deg) for row in rows]
    # 3e-5 is 6.2 arc seconds, the cosine of half a degree does not show
    assert text[tilt + 1].split()[2:] == ["6.2", "6.2", "6.2", "--"]
    deviation = next(k for k, line in enumerate(text) if line.startswith("deviation at 102 m (m)"))
    assert text[deviation + 1].split()[2:] == ["3.1", "3.1", "3.1", "--"]


def test_table_3_shows_mean_and_control_and_what_is_allowed(rows: list[TiltRow], control: Control) -> None:
    text = comparison_lines(comparison_table(rows, control))
    assert text[1].split() == ["A", "C", "E", "mean", "control", "F/paper"]
    deviation = next(k for k, line in enumerate(text) if line.startswith("deviation"))
    assert text[deviation].split()[-1] == f"{control.deviation_m:.4f}"
    assert text[deviation + 1].split()[-1] == "--"
    assert "allowable deviation at 102 m (mm): 60.5" in text


def test_workload_is_shown_for_each_scheme_that_cuts_more(rows: list[TiltRow]) -> None:
    text = workload_lines(slice_counts(rows))
    assert [line.split() for line in text[1:]] == [
        ["C", "E", "F"],
        ["A", "9.2", "50.5", "50.5"],
        ["C", "--", "5.5", "5.5"],
    ]


def test_recommendation_shows_the_savings_against_the_densest_scheme(rows: list[TiltRow]) -> None:
    text = recommendation_lines(slice_counts(rows))
    assert len(text) == 4
    assert "workload of C 9.2 times less than A" in text[2]
    assert "workload of E 50.5 times less than A" in text[3]
