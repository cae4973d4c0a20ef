"""status, compare, verify and export of what is stored."""

import csv
import json
from pathlib import Path

import pytest

from storage.catalog import rebuild_catalog
from storage.series import publish_series
from storage.views import change_rows
from tasks.epoch_difference import epoch_tests
from tests.flows.calls import call
from tests.flows.stored_campaign import Stored, publish, publish_without_result, stored_campaign

FAIL = {"verdict": "fail", "allowable_m": 0.0605, "verdict_reason": "921 mm against 60.5 mm"}
PASS = {"verdict": "pass", "allowable_m": 2.0, "verdict_reason": None}
UNSURE = {"verdict": "cannot tell", "allowable_m": 0.9207, "verdict_reason": None}


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    return stored_campaign(tmp_path)


def test_state_without_findings_is_ok(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0, PASS)
    publish(stored, "e2", 1, PASS)
    called = call(capsys, "status", stored.file)
    assert (called.code, called.err) == (0, "")
    lines = called.out.splitlines()
    assert lines[0].startswith("chimney-01, epoch e2, measured 2026-03-13 22:00 UTC, ")
    assert lines[1] == "deviation: 920.8 ± 4.0 mm (k=2) at 102 m, towards 129.2° (A/paper)"
    assert lines[2] == "limit: 2000.0 mm, verdict: pass"
    assert lines[3].startswith("change: since e1: 0.0 ± ")
    assert "not significant (p = 1; from " in lines[3]
    assert lines[4] == "data: ok, 2 of 2 stations, 40,000 of 100,000 points on the shaft"
    assert lines[5:] == ["state: ok"]


def test_an_unseen_side_is_told_with_the_place_of_one_more_station(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    outlook = {
        "coverage_deg": 213.0,
        "stations_sigma_arcsec": 3.24,
        "next_station_azimuth_deg": 90.0,
        "next_station_sigma_arcsec": 2.0,
    }
    publish(stored, "e1", 0, PASS, **outlook)
    called = call(capsys, "status", stored.file)
    assert called.code == 0
    expected = (
        "coverage: 213° of the circumference; one more station at azimuth 90° would bring the sigma of the lean "
        'from 3.2" to 2.0"'
    )
    assert called.out.splitlines()[-2] == expected
    answer = call(capsys, "status", stored.file, "--json").answer
    assert {name: answer[name] for name in outlook} == outlook


@pytest.mark.parametrize(
    ("covered_deg", "then_arcsec", "told"), [(355.0, 1.9, False), (355.0, 1.6, True), (290.0, 1.9, True)]
)
def test_coverage_is_told_only_where_a_station_would_be_worth_the_way(
    capsys: pytest.CaptureFixture[str], stored: Stored, covered_deg: float, then_arcsec: float, told: bool
) -> None:
    sigmas = {"stations_sigma_arcsec": 2.0, "next_station_sigma_arcsec": then_arcsec}
    publish(stored, "e1", 0, PASS, coverage_deg=covered_deg, next_station_azimuth_deg=40.0, **sigmas)
    assert ("coverage: " in call(capsys, "status", stored.file).out) is told


def test_coverage_of_a_registered_cloud_is_told_without_a_station(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish(stored, "e1", 0, PASS, coverage_deg=180.0)
    assert "coverage: 180° of the circumference\n" in call(capsys, "status", stored.file).out


def test_deviation_above_its_limit_is_an_alarm(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0, FAIL)
    called = call(capsys, "status", stored.file)
    assert called.code == 6
    assert "limit: 60.5 mm, verdict: fail; 921 mm against 60.5 mm" in called.out
    assert "  alarm: the deviation is above its limit" in called.out
    assert "change: none: this is the reference epoch" in called.out


def test_limit_within_the_uncertainty_is_a_warning(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish(stored, "e1", 0, UNSURE)
    called = call(capsys, "status", stored.file)
    assert called.code == 5
    assert "  warning: the limit lies within the uncertainty of the deviation" in called.out


def test_significant_change_is_a_warning(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0, PASS)
    publish(stored, "e2", 1, PASS, moved_m=0.05)
    called = call(capsys, "status", stored.file)
    assert called.code == 5
    assert "change: since e1: 50.0 ± 5.8 mm (k=2) at the top, significant (p < " in called.out
    assert "  warning: the change since e1 is significant" in called.out


def test_degraded_epoch_does_not_pass_the_quality_gate(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish(stored, "e1", 0, PASS, state="degraded", reason="station ST02: no such file")
    called = call(capsys, "status", stored.file)
    assert called.code == 4
    assert "  quality gate not passed: the epoch is degraded: station ST02: no such file" in called.out


def test_epoch_without_result_does_not_pass_the_quality_gate(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish_without_result(stored, "e1", 0, state="failed", reason="no scan of the epoch could be read")
    called = call(capsys, "status", stored.file)
    assert called.code == 4
    assert "deviation: no result of A/paper" in called.out
    assert "  quality gate not passed: the primary A/paper gave no axis" in called.out


def test_highest_finding_wins(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0, PASS)
    publish(stored, "e2", 1, FAIL, moved_m=0.05, state="degraded", reason="x")
    assert call(capsys, "status", stored.file).code == 6


def test_state_is_that_of_the_newest_epoch(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0, FAIL)
    publish(stored, "e2", 1, PASS)
    assert call(capsys, "status", stored.file).code == 0


def test_status_answers_programs(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0, FAIL)
    called = call(capsys, "status", stored.file, "--json")
    answer = called.answer
    assert (called.code, answer["ok"], answer["exit_code"], answer["level"]) == (6, False, 6, "alarm")
    assert (answer["verdict"], answer["change_m"], answer["not_processed"]) == ("fail", None, ["e2"])
    assert answer["deviation_u_m"] == pytest.approx(0.004)


def test_status_tells_what_is_not_processed(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0, PASS)
    assert call(capsys, "status", stored.file).err == "not processed yet: e2\n"


def test_status_without_workspace_says_what_to_do(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    called = call(capsys, "status", stored.file, "--workspace", stored.file.parent / "none")
    assert called.code == 3
    assert "process the campaign first with `tiltwatch run FILE`, or name the right folder" in called.err


def test_status_of_an_empty_workspace_says_what_to_do(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    called = call(capsys, "status", stored.file)
    assert called.code == 3
    assert called.err.startswith("error: ")
    assert "Traceback" not in called.err


def test_compare_names_the_primary_and_its_significance(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish(stored, "e1", 0)
    publish(stored, "e2", 1, moved_m=0.05)
    called = call(capsys, "compare", stored.file, "e2", "e1")
    assert called.code == 0
    title, first, second, *besides = called.out.splitlines()
    assert (
        title == "Heritage chimney: movement of the top at 102 m against the foot, by the lean, from e1 to e2"
    )
    assert first.startswith(
        "A/paper: 50.00 ± 5.77 mm (k=2), east +50.00 mm, north +0.00 mm, significant (p < "
    )
    assert "  <- primary (" in first
    assert second.startswith("F/paper: 50.00 ± 5.77 mm")
    assert besides[1] == "A/paper besides:"
    assert besides[2].startswith("foot of the axis moved ")


def test_difference_of_two_epochs_is_that_of_the_catalog(stored: Stored) -> None:
    publish(stored, "e1", 0)
    publish(stored, "e2", 1, moved_m=0.003)
    tests = epoch_tests(stored.workspace, "chimney-01", "e2", "e1")
    publish_series(stored.workspace, "chimney-01", {"change_tests": tests})
    before = change_rows(stored.workspace, "chimney-01", "e2")
    rebuild_catalog(stored.workspace)
    ours = [row for row in tests if row.quantity == "lean"]
    for row, stated in zip(ours, change_rows(stored.workspace, "chimney-01", "e2"), strict=True):
        for name, of_view in NAMES_IN_VIEW.items():
            assert getattr(row, name) == pytest.approx(getattr(stated, of_view), rel=1e-5), name
        assert (row.significant, row.basis) == (stated.significant, stated.basis)
    # nothing is in common here: the view says the same before the epochs are compared, and that they are not yet
    for row, stated in zip(before, change_rows(stored.workspace, "chimney-01", "e2"), strict=True):
        assert row.chi2 == pytest.approx(stated.chi2)
        assert row.basis == "sum of both"


NAMES_IN_VIEW = {
    "d_east": "d_lean_east",
    "size_m": "d_top_m",
    "sigma_m": "sigma_top_m",
    "statistic": "chi2",
    "p_value": "p_value",
    "smallest_detectable_m": "smallest_detectable_m",
    "d_cov_en": "d_cov_en",
}


def test_compare_answers_programs(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0)
    publish(stored, "e2", 1, moved_m=0.05)
    answer = call(capsys, "compare", stored.file, "e2", "e1", "--json").answer
    assert [(row["scheme"], row["significant"]) for row in answer["changes"]] == [("A", True), ("F", True)]


def test_compare_with_an_unknown_epoch_names_the_known(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    called = call(capsys, "compare", stored.file, "e3", "e1")
    assert (called.code, called.err) == (2, "error: unknown epoch 'e3'; known: e1, e2\n")


def test_compare_with_itself_is_wrong_usage(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    called = call(capsys, "compare", stored.file, "e1", "e1")
    assert (called.code, called.err) == (
        2,
        "error: epoch 'e1' cannot be compared with itself; name two epochs\n",
    )


def test_compare_with_an_unprocessed_epoch_says_what_to_do(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish(stored, "e1", 0)
    called = call(capsys, "compare", stored.file, "e2", "e1")
    assert called.code == 3
    assert "epoch e2 of chimney-01 is not stored yet; `tiltwatch run` processes it" in called.err


@pytest.mark.parametrize("deep", [[], ["--deep"]])
def test_whole_workspace_is_verified(
    capsys: pytest.CaptureFixture[str], stored: Stored, deep: list[str]
) -> None:
    publish(stored, "e1", 0)
    called = call(capsys, "verify", stored.file, *deep)
    assert (called.code, called.err) == (0, "")
    assert called.out.endswith(" checked, 0 faults\n")


def test_damaged_table_is_found(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0)
    (table,) = (stored.workspace.tables / "tilt").glob("*/e1.parquet")
    table.write_bytes(table.read_bytes()[:-10])
    called = call(capsys, "verify", stored.file, "--json")
    assert called.code == 3
    assert "error: tables/tilt/chimney-01/e1.parquet: " in called.err
    assert called.answer["faults"]


def test_export_writes_a_file(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0)
    out = stored.file.parent / "tilt.csv"
    called = call(capsys, "export", stored.file, "tilt", "--format", "csv", "--out", out)
    assert (called.code, called.out, called.err) == (0, "", f"wrote {out}\n")
    with out.open(encoding="utf-8", newline="") as lines:
        assert [row["scheme"] for row in csv.DictReader(lines)] == ["A", "F"]


def test_export_goes_to_stdout_where_no_file_is_named(
    capfdbinary: pytest.CaptureFixture[bytes], stored: Stored
) -> None:
    publish(stored, "e1", 0)
    from flows.cli import main  # noqa: PLC0415 (stdout is captured as bytes here)

    assert main(["export", str(stored.file), "epochs", "--format", "json"]) == 0
    assert [row["epoch"] for row in json.loads(capfdbinary.readouterr().out)] == ["e1"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["tilts", "--format", "csv"], "unknown view 'tilts'; known: epochs, "),
        (["tilt", "--format", "xls"], "unknown export format 'xls'; known: csv, json, parquet"),
        (
            ["tilt", "--format", "csv", "--json"],
            "--json answers on stdout, where the table would go; name a file",
        ),
    ],
)
def test_export_of_what_there_is_not_is_wrong_usage(
    capsys: pytest.CaptureFixture[str], stored: Stored, words: list[str], message: str
) -> None:
    publish(stored, "e1", 0)
    called = call(capsys, "export", stored.file, *words)
    assert called.code == 2
    assert message in called.err
