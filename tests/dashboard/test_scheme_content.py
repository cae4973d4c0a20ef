"""Schemes of an epoch beside each other: from rows to what tables and drawings show."""

import math
from dataclasses import replace
from datetime import timedelta

import pytest

from dashboard.content.scheme_differences import differences, drawable
from dashboard.content.scheme_tables import accuracy_sheet, comparison_sheet, fitting_sheet, monitoring_sheet
from dashboard.content.schemes import (
    Given,
    Way,
    control_of,
    marks,
    means,
    near_range,
    recommended,
    seconds_of,
    stored_control,
    ways,
)
from dashboard.content.sheet import Line, Sheet
from dashboard.figures.schemes import deviations, over_epochs
from storage.records import AccuracyRow, SchemeComparisonRow, StageRunRow, TiltRow
from tests.storage.campaign import (
    STRUCTURE,
    reference_lean_row,
    scheme_comparison_row,
    scheme_row,
    slice_row,
    stage_run_row,
    tilt_row,
)

DIRECT = {
    "iterations": None,
    "update_weight_ratio_pct": None,
    "n_effective": None,
    "mean_deviation_m": None,
    "rmse_m": None,
}


def comparison(scheme: str, method: str, **changed: object) -> SchemeComparisonRow:
    row = replace(
        scheme_comparison_row("e0"),
        compared=f"{scheme}/{method}",
        scheme=scheme,
        method=method,
        height_m=100.0,
    )
    return replace(row, is_recommended=False, reason=None, **changed)


def found(**changed: object) -> list[Way]:
    """A in both methods, E through two centres, F without an axis; A/robust is the primary."""
    failed = replace(scheme_row("e0"), scheme="F", state="failed", reason="needs <2> centres")
    given = {
        "schemes": [
            scheme_row("e0"),
            replace(scheme_row("e0"), method="robust"),
            replace(scheme_row("e0"), scheme="E"),
            failed,
        ],
        "tilts": [
            tilt_row("e0"),
            tilt_row("e0", method="robust"),
            tilt_row("e0", scheme="E", lean=(0.008, -0.006), **DIRECT),
        ],
        "comparison": [
            comparison("A", "paper", d_top_m=0.002, d_sigma_top_m=0.0015, p_value=0.4, significant=False),
            comparison("A", "robust"),
        ],
        "slices": [slice_row("e0", index) for index in range(3)],
        "runs": [],
        **changed,
    }
    return ways(Given(**given), ("A", "robust"))  # type: ignore[arg-type]


def line(sheet: Sheet, label: str) -> Line:
    return next(line for line in sheet.lines if line.cells[0].text == label)


def test_every_scheme_stands_there_the_failed_one_with_its_reason() -> None:
    assert [way.label for way in found()] == ["A/robust", "A/paper", "E/paper", "F/paper"]
    for sheet in (
        fitting_sheet(found()),
        monitoring_sheet(found()),
        comparison_sheet(found(), [], "A/robust"),
    ):
        assert line(sheet, "F/paper").instead == "no axis: needs <2> centres"
        assert line(sheet, "F/paper").kind == "gone"


def test_a_line_through_two_centres_has_no_residual_and_the_cell_says_why() -> None:
    cells = line(fitting_sheet(found()), "E/paper").cells
    assert [cell.text for cell in cells[2:7]] == ["--"] * 5
    assert all("two centres" in (cell.why or "") for cell in cells[2:7])


def test_table_1_writes_the_rows_in_millimetres_and_their_means() -> None:
    sheet = fitting_sheet(found())
    assert [cell.text for cell in line(sheet, "A/paper").cells[1:7]] == [
        "5",
        "7",
        "0.0",
        "1.00",
        "1.20",
        "4.9",
    ]
    assert line(sheet, "A/robust").kind == "marked"
    # E has none, so that paper has one scheme and no mean
    assert not [row for row in sheet.lines if row.kind == "mean"]
    tilts = [tilt_row("e0"), tilt_row("e0", scheme="B", rmse_m=0.0020)]
    both = fitting_sheet(ways(Given([], tilts, [], [], []), ("S", "surface")))
    assert [cell.text for cell in line(both, "mean, paper").cells[4:6]] == ["1.00", "1.60"]


def test_table_2_writes_the_vector_with_eight_decimals_and_the_deviation_with_u() -> None:
    tilt = tilt_row("e0")
    cells = line(monitoring_sheet(found()), "A/paper").cells
    assert cells[4].text.split()[2] == f"{tilt.d_up:.8f}"
    assert cells[2].text == "3"
    assert cells[9].text == f"{1e3 * tilt.deviation_m:.1f} ± 4.0"
    assert cells[10].text == "no limit"


def test_without_covariance_or_direction_there_is_no_number_and_never_zero() -> None:
    bare = tilt_row("e0", deviation_sigma_m=None, azimuth_deg=None, azimuth_sigma_deg=None)
    cells = line(monitoring_sheet(found(tilts=[bare])), "A/paper").cells
    assert cells[9].text.endswith("± --")
    assert cells[9].why is not None
    assert (cells[6].text, cells[6].why) == ("--", "the lean is below 3 sigma: it has no direction")


def test_relative_errors_are_those_of_equation_23() -> None:
    row = AccuracyRow(STRUCTURE, "e0", "A", "paper", "F/paper", "tilt_deg", 0.6, 0.5, 0.1, 20.0)
    others = [
        replace(row, quantity="beta_deg", value=90.0, reference=90.0, relative_error_pct=0.0),
        replace(row, quantity="verticality_permille", value=10.0, reference=8.0, relative_error_pct=25.0),
        replace(row, quantity="deviation_m", value=1.0, reference=0.9, relative_error_pct=11.1),
    ]
    control = stored_control([row, *others])
    assert control is not None
    tilt = tilt_row("e0", tilt_deg=0.6, beta_deg=90.0, verticality_permille=10.0, deviation_m=1.0)
    cells = line(accuracy_sheet(found(tilts=[tilt]), control), "A/paper").cells
    assert [cell.text for cell in cells[1:]] == ["0.000", "20.000", "25.000", "11.111", "+100.0"]
    assert stored_control([]) is None


def test_the_control_may_be_any_scheme_and_is_left_out_of_the_mean() -> None:
    three = found(
        tilts=[
            tilt_row("e0", scheme=scheme, deviation_m=value)
            for scheme, value in (("A", 1.0), ("B", 1.2), ("F", 0.8))
        ]
    )
    control = control_of(next(way for way in three if way.scheme == "F"))
    assert control is not None
    schemes, mean_m, error_pct = means(three, "deviation_m", control)["paper"]
    assert (schemes, mean_m) == (["A", "B"], pytest.approx(1.1))
    assert error_pct == pytest.approx(37.5)
    assert line(accuracy_sheet(three, control), "F/paper").instead == "the control itself"
    assert control_of(found()[3]) is None


def test_measurements_by_other_means_stand_below_the_schemes() -> None:
    measured = replace(
        comparison("A", "paper"),
        compared="total station",
        scheme=None,
        method=None,
        d_top_m=0.003,
        d_sigma_top_m=0.002,
        p_value=0.3,
        significant=False,
    )
    sheet = comparison_sheet(found(), [measured], "A/robust")
    assert sheet.lines[-1].cells[0].text == "total station"
    assert sheet.lines[-1].cells[3].text == "3.0 ± 4.0"
    assert line(sheet, "A/robust").instead == "what the others are compared with"
    assert line(sheet, "E/paper").instead == "it was not compared in this epoch"


def run(stage: str, name: str, seconds: float | None, key: str, hours: int = 0) -> StageRunRow:
    row = stage_run_row(name, "e0")
    state = "cached" if seconds is None else "computed"
    later = row.started_at + timedelta(hours=hours)
    return replace(row, stage=stage, seconds=seconds, state=state, cache_key=key, started_at=later)


def test_seconds_of_a_cached_stage_are_those_of_the_run_that_computed_it() -> None:
    rows = [
        run("slicing A/paper", "run-1", 2.0, "s1"),
        run("axis A/paper", "run-1", 1.0, "a1"),
        run("slicing A/paper", "run-2", None, "s1", 1),
        run("axis A/paper", "run-2", 0.5, "a2", 1),
        run("axis A/robust", "run-2", 9.0, "r", 1),
    ]
    assert seconds_of(rows, ("A", "paper")) == (2.5, None)
    assert seconds_of(rows[2:], ("A", "paper"))[0] is None
    assert seconds_of(rows, ("B", "paper")) == (None, "no run of the ledger tells of it")


def test_only_a_recommended_scheme_is_recommended() -> None:
    assert recommended(found()) is None
    chosen = found(comparison=[replace(comparison("E", "paper"), is_recommended=True)])
    assert recommended(chosen) is chosen[2]


def test_differences_are_taken_along_the_lean_with_what_both_share_taken_out() -> None:
    base = tilt_row("e0", lean=(0.006, 0.008), method="robust")
    other = tilt_row("e0", lean=(0.0066, 0.0088))
    compared = comparison("A", "paper", d_cov_ee=4e-10, d_cov_en=0.0, d_cov_nn=9e-10)
    compared = replace(compared, against="A/robust", significant=True)
    (series,) = differences([base, other], [compared], "A/robust").values()
    assert series[0].value_m == pytest.approx(102.0 * 0.001)
    assert series[0].sigma_m == pytest.approx(100.0 * math.sqrt(4e-10 * 0.36 + 9e-10 * 0.64))
    assert series[0].significant is True
    (unknown,) = differences([base, other], [], "A/robust").values()
    assert unknown[0].sigma_m is None
    assert differences([other], [], "A/robust") == {}


def test_a_wild_scheme_is_named_and_not_drawn() -> None:
    base = tilt_row("e0", method="robust")
    tilts: list[TiltRow] = [base]
    rows = []
    for scheme, sigma in (("A", 1e-5), ("B", 2e-5), ("F", 1e-2)):
        tilts.append(tilt_row("e0", scheme=scheme))
        row = comparison(scheme, "paper", d_cov_ee=sigma**2, d_cov_en=0.0, d_cov_nn=sigma**2)
        rows.append(replace(row, against="A/robust"))
    drawn, wild = drawable(differences(tilts, rows, "A/robust"))
    assert list(drawn) == ["A/paper", "B/paper"]
    assert wild == {"F/paper": pytest.approx(1.0)}


def test_the_limit_and_every_bar_lie_in_the_left_drawing_and_the_primary_in_the_right_one() -> None:
    shown = marks(found(), [reference_lean_row("e0", source="<i>level</i>")])
    figure = deviations(shown, 0.0605)
    low, high = figure.layout.xaxis.range
    assert low < 0.0
    assert high > 1e3 * max(mark.value_m + 2.0 * (mark.sigma_m or 0.0) for mark in shown)
    middle = 1e3 * next(mark.value_m for mark in shown if mark.is_primary)
    near = figure.layout.xaxis2.range
    assert near[0] < middle < near[1]
    assert "&lt;i&gt;level&lt;/i&gt;" in [trace.y[0] for trace in figure.data]
    assert deviations(shown[:1], None).layout.xaxis.range[0] < 0.0


def test_differences_are_drawn_in_millimetres_beside_their_epoch() -> None:
    base = tilt_row("e0", lean=(0.006, 0.008), method="robust")
    figure = over_epochs(
        differences([base, tilt_row("e0", lean=(0.0066, 0.0088))], [], "A/robust"), "A/robust", ["e0", "e1"]
    )
    assert figure.data[0].y[0] == pytest.approx(102.0)
    assert figure.data[0].x[0] == pytest.approx(0.0)
    assert figure.layout.yaxis.range[1] > 102.0


def test_a_wild_value_hides_no_other() -> None:
    values = [(1.0, 0.1), (1.1, 0.1), (0.9, 0.1), (50.0, 100.0)]
    assert near_range(values, 1.0) == pytest.approx(0.2)
    with pytest.raises(ValueError, match="got none"):
        near_range([], 0.0)
