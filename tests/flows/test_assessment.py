"""What follows from all epochs: changes, trend, chart and alarms, from stored rows alone."""

import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from filelock import FileLock, Timeout

from flows.assess_structure import assess_structure
from storage.assessed import put_down_assessed
from storage.atomic import write_atomically
from storage.catalog import rebuild_catalog
from storage.publish import publish_epoch, remove_epoch
from storage.records import CoverageRow
from storage.tables import SERIES, table_path
from storage.views import (
    alarm_rows,
    change_rows,
    change_test_rows,
    control_chart_rows,
    tilt_rows,
    trend_rows,
)
from storage.workspace import Workspace
from tasks import assessment
from tasks.assessment import assess
from tasks.settings import Campaign, load_campaign
from tests.flows.stored_campaign import Stored, publish, publish_without_result, stored_campaign
from tests.storage.campaign import axis_covariance_rows, axis_parameter_rows, coverage_row, epoch_tables

STRUCTURE = "chimney-01"
PRIMARY = ("A", "paper")
RATE_MM_PER_YEAR = 12.0


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    return stored_campaign(tmp_path)


def primary(rows: list) -> list:  # type: ignore[type-arg]
    return [row for row in rows if (row.scheme, row.method) == PRIMARY]


def campaign_of(stored: Stored) -> Campaign:
    return load_campaign(stored.file)


def test_twelve_epochs_that_begin_to_move_at_the_seventh_are_found_dated_and_measured(stored: Stored) -> None:
    rng = np.random.default_rng(12)
    for number in range(12):
        moved_m = RATE_MM_PER_YEAR * 1e-3 * max(0, number - 6)
        publish(stored, f"e{number:02d}", number, moved_m=moved_m + 2e-3 * float(rng.normal()))
    assess_structure(stored.workspace, campaign_of(stored))
    (trend,) = primary(trend_rows(stored.workspace, STRUCTURE))
    assert trend.n_epochs == 12
    assert trend.change_point_kind == "rate"
    assert trend.change_point_p_value is not None
    assert trend.change_point_p_value < 0.01
    begun = {row.epoch: row.epoch_time for row in primary(tilt_rows(stored.workspace, STRUCTURE))}["e06"]
    assert trend.change_point_earliest <= begun <= trend.change_point_latest
    error = trend.rate_after_m_per_year - 1e-3 * RATE_MM_PER_YEAR
    assert abs(error) < 2.5 * trend.rate_after_sigma_m_per_year
    chart = primary(control_chart_rows(stored.workspace, STRUCTURE))
    assert [row.signal for row in chart if row.epoch < "e06"] == ["none"] * 5
    assert chart[-1].signal == "alarm"
    rules = {alarm.rule for alarm in alarm_rows(stored.workspace, STRUCTURE)}
    assert {"moved-1pct", "cusum-alarm"} <= rules


def test_what_is_assessed_again_without_news_stays_as_it_is(stored: Stored) -> None:
    for number in range(3):
        publish(stored, f"e{number}", number, moved_m=0.02 * number)
    campaign = campaign_of(stored)
    assess_structure(stored.workspace, campaign)
    inode = stored.workspace.catalog.stat().st_ino
    alarms = alarm_rows(stored.workspace, STRUCTURE)
    assert alarms
    assess_structure(stored.workspace, campaign)
    assert stored.workspace.catalog.stat().st_ino == inode
    assert alarm_rows(stored.workspace, STRUCTURE) == alarms


def test_a_structure_is_assessed_again_where_an_epoch_or_a_series_or_a_setting_changed(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(2):
        publish(stored, f"e{number}", number, moved_m=0.02 * number)
    campaign = campaign_of(stored)
    assessed: list[str] = []

    def noted(workspace: Workspace, of: Campaign):  # type: ignore[no-untyped-def]
        assessed.append(of.structure.id)
        return assess(workspace, of)

    monkeypatch.setattr("flows.assess_structure.assess", noted)
    counts = []
    for change in (
        lambda: None,
        lambda: None,
        lambda: publish(stored, "e1", 1, moved_m=0.05, run="20260101T000000Z-other"),
        lambda: table_path(stored.workspace, "trends", STRUCTURE, SERIES).unlink(),
        lambda: monkeypatch.setattr("flows.assess_structure.program_digest", lambda: "another"),
        lambda: None,
    ):
        change()
        assess_structure(stored.workspace, campaign)
        counts.append(len(assessed))
    assert counts == [1, 1, 2, 3, 4, 4]
    assert table_path(stored.workspace, "trends", STRUCTURE, SERIES).is_file()


def test_only_epochs_that_are_new_or_changed_are_compared_again(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(3):
        publish(stored, f"e{number}", number, moved_m=0.02 * number)
    campaign = campaign_of(stored)
    assess_structure(stored.workspace, campaign)
    loaded: list[str] = []
    load = assessment.load_epoch_record

    def noted(workspace: Workspace, epoch):  # type: ignore[no-untyped-def]
        loaded.append(epoch.epoch)
        return load(workspace, epoch)

    monkeypatch.setattr(assessment, "load_epoch_record", noted)
    assess(stored.workspace, campaign)
    assert loaded == []
    publish(stored, "e2", 2, moved_m=0.05, run="20260101T000000Z-other")
    changed = primary(list(assess(stored.workspace, campaign)["change_tests"]))
    assert sorted(loaded) == ["e0", "e2"]
    lean = {row.epoch: row for row in changed if row.quantity == "lean"}
    assert lean["e2"].size_m == pytest.approx(0.05)
    assert lean["e1"].size_m == pytest.approx(0.02)


def test_view_counts_from_the_plain_difference_until_the_epoch_is_compared(stored: Stored) -> None:
    for number in range(2):
        publish(stored, f"e{number}", number, moved_m=0.02 * number)
    assert {row.basis for row in change_rows(stored.workspace, STRUCTURE)} == {"sum of both"}
    assess_structure(stored.workspace, campaign_of(stored))
    assert {row.basis for row in primary(change_rows(stored.workspace, STRUCTURE))} == {"free"}
    publish(stored, "e1", 1, moved_m=0.03, run="20260101T000000Z-other")
    (stale,) = primary(change_rows(stored.workspace, STRUCTURE))
    assert (stale.basis, stale.d_top_m) == ("sum of both", pytest.approx(0.03))


def test_form_of_the_wall_cancels_between_epochs_that_saw_the_same(stored: Stored) -> None:
    form = 0.9
    for number in range(2):
        tables = epoch_tables(f"e{number}", number)
        (tilt,) = tables["tilt"]
        rows = axis_covariance_rows(tilt)  # type: ignore[arg-type]
        tables["axis_parameters"] = list(axis_parameter_rows(tilt))  # type: ignore[arg-type]
        tables["axis_covariances"] = [replace(row, form_covariance=form * row.covariance) for row in rows]
        tables["coverage"] = list(ring_coverage(f"e{number}"))
        publish_epoch(stored.workspace, STRUCTURE, f"e{number}", tables)
    rebuild_catalog(stored.workspace)
    (before,) = primary(change_rows(stored.workspace, STRUCTURE))
    tests = assess(stored.workspace, campaign_of(stored))["change_tests"]
    (lean,) = [row for row in primary(list(tests)) if row.quantity == "lean"]
    assert lean.basis == "free"
    assert lean.d_cov_ee == pytest.approx((1.0 - form) * before.d_cov_ee)


def ring_coverage(epoch: str) -> list[CoverageRow]:
    return [
        replace(
            coverage_row(epoch, low),
            z_low_m=low,
            z_high_m=low + 20.0,
            azimuth_low_deg=azimuth,
            azimuth_high_deg=azimuth + 60.0,
            n_points=500,
        )
        for low in (0.0, 20.0, 40.0, 60.0)
        for azimuth in range(0, 360, 60)
    ]


def test_epochs_without_an_axis_are_not_loaded_in_every_run(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    publish(stored, "e0", 0)
    publish_without_result(stored, "e1", 1, state="failed")
    monkeypatch.setattr(assessment, "load_epoch_record", lambda *_: pytest.fail("loaded"))
    assert list(assess(stored.workspace, campaign_of(stored))["change_tests"]) == []


def test_tests_of_an_epoch_that_is_gone_are_not_shown(stored: Stored) -> None:
    for number in range(3):
        publish(stored, f"e{number}", number, moved_m=0.02 * number)
    assess_structure(stored.workspace, campaign_of(stored))
    remove_epoch(stored.workspace, STRUCTURE, "e2")
    rebuild_catalog(stored.workspace)
    assert {row.epoch for row in change_test_rows(stored.workspace, STRUCTURE)} == {"e1"}


def test_a_structure_without_any_epoch_has_nothing_to_follow(stored: Stored) -> None:
    rebuild_catalog(stored.workspace)
    shutil.rmtree(stored.workspace.tables, ignore_errors=True)
    found = assess(stored.workspace, campaign_of(stored))
    assert {table: list(rows) for table, rows in found.items()} == {
        "change_tests": [],
        "trends": [],
        "control_chart": [],
    }
    assert change_test_rows(stored.workspace, STRUCTURE) == []


def test_what_is_put_down_as_assessed_cannot_be_swept_away_meanwhile(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = []

    def write(path: Path, content: bytes) -> None:
        with FileLock(stored.workspace.locks / "publish.lock").acquire(timeout=0.0):
            held.append(path)
        write_atomically(path, content)

    def write_and_see(path: Path, content: bytes) -> None:
        with pytest.raises(Timeout), ThreadPoolExecutor(1) as pool:
            pool.submit(write, path, content).result()
        write_atomically(path, content)

    monkeypatch.setattr("storage.assessed.write_our_own", write_and_see)
    put_down_assessed(stored.workspace, STRUCTURE, "basis")
    assert held == []


def test_an_epoch_published_while_another_run_assesses_is_assessed_by_the_next(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(2):
        publish(stored, f"e{number:02d}", number, moved_m=0.0)

    def assess_late(workspace: Workspace, campaign: Campaign) -> object:
        # another run publishes after this one took its basis
        if not monkeypatched:
            monkeypatched.append(True)
            publish(stored, "e02", 2, moved_m=0.0)
        return assess(workspace, campaign)

    monkeypatched: list[bool] = []
    monkeypatch.setattr("flows.assess_structure.assess", assess_late)
    assess_structure(stored.workspace, campaign_of(stored))
    assess_structure(stored.workspace, campaign_of(stored))
    assert {row.epoch for row in change_test_rows(stored.workspace, STRUCTURE)} >= {"e01", "e02"}
