"""A report of an epoch does not change when later epochs come."""

from dataclasses import replace
from pathlib import Path

from dashboard.report.alarm_log import alarms_at
from dashboard.report.page import html_of
from storage.catalog import rebuild_catalog
from storage.workspace import Workspace, open_workspace
from tests.dashboard.report.reported import document, facts_of, limited, publish, publish_one
from tests.storage.campaign import alarm_event_row


def test_a_later_epoch_leaves_the_report_as_it_was(tmp_path: Path) -> None:
    ws = open_workspace(tmp_path / "ws")
    publish(ws, 2, limited)
    before = html_of(document(ws, "e1"))
    publish_one(ws, 2)
    rebuild_catalog(ws)
    assert html_of(document(ws, "e1")) == before
    assert [each.epoch.epoch for each in facts_of(ws, "e2").history] == ["e0", "e1", "e2"]


def test_its_date_is_that_of_the_last_stage_not_of_today(published: Workspace) -> None:
    facts = facts_of(published)
    assert facts.published_at == max(row.started_at for row in facts.stages)
    assert facts.stages


def test_alarms_are_told_as_they_stood_at_the_epoch() -> None:
    raised = replace(alarm_event_row("1"), note="moved by 21 mm")
    updated = replace(alarm_event_row("2", "updated", 1), epoch="e1", note="moved by 40 mm")
    seen = alarm_event_row("3", "acknowledged", 2)
    closed = replace(alarm_event_row("4", "closed", 3), epoch="e2")
    then = alarms_at([closed, seen, updated, raised], {"e0"})
    assert [(each.what, each.state, each.person) for each in then] == [
        ("moved by 21 mm", "acknowledged", "A. Surveyor")
    ]
    assert alarms_at([closed, seen, updated, raised], {"e0", "e1", "e2"})[0].state == "closed"
    assert alarms_at([updated], {"e1"}) == (), "one that was not raised by then is none"
