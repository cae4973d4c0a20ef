"""The pages of schemes, data quality, alarms and runs, filled from a small workspace."""

from dataclasses import replace
from pathlib import Path

import flask
import pytest
from dash.development.base_component import Component

from dashboard.address import Address
from dashboard.downloads import serve_files
from dashboard.page import pages
from dashboard.panel import Panel
from dashboard.reader import Reader
from dashboard.rule import RuleWords
from dashboard.shell import page_frame
from dashboard.view import Site, View, open_view
from storage.alarm_log import append_alarm_event
from storage.catalog import rebuild_catalog
from storage.errors import UsageError
from storage.publish import publish_epoch
from storage.views import run_rows_of
from storage.workspace import Workspace, open_workspace
from tests.storage.campaign import (
    STRUCTURE,
    alarm_event_row,
    epoch_row,
    epoch_tables,
    fill,
    scheme_row,
    station_row,
    tilt_row,
)

NAMES = ("schemes", "quality", "alarms", "runs")
HOSTILE = "<img src=x onerror=alert(1)>\"'&"
RULE = RuleWords("movement", "moved", "warning", "it moved", "p = 0.01", "measure again")
SITES = {STRUCTURE: Site("Chimney", ("A", "paper"), "campaign.toml", (RULE,))}


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """e0 and e1 whole, e2 with a failed scheme and station, e3 failed wholly."""
    ws = open_workspace(tmp_path_factory.mktemp("pages") / "ws")
    fill(ws)
    lost = replace(
        station_row("e2", "ST02"),
        state="failed",
        reason=HOSTILE,
        scan_digest=None,
        n_points=None,
        position_east_m=None,
    )
    degraded = epoch_tables("e2", 2, state="degraded", reason=HOSTILE)
    degraded["stations"] = [station_row("e2"), lost]
    degraded["schemes"] = [
        scheme_row("e2"),
        replace(scheme_row("e2"), scheme="F", state="failed", reason=HOSTILE),
    ]
    degraded["tilt"] = [tilt_row("e2", 2, deviation_sigma_m=None, warning=HOSTILE)]
    publish_epoch(ws, STRUCTURE, "e2", degraded)
    nothing: dict[str, list[object]] = {name: [] for name in degraded}
    publish_epoch(
        ws, STRUCTURE, "e3", {**nothing, "epochs": [epoch_row("e3", 3, state="failed", reason=HOSTILE)]}
    )
    append_alarm_event(ws, replace(alarm_event_row("20260101T000000.000000Z-0000"), note=HOSTILE))
    rebuild_catalog(ws)
    return ws


def view_of(ws: Workspace, page: str, **choice: str) -> View:
    fixed = {key: choice.pop(key) for key in ("epoch", "scheme", "method") if key in choice}
    view = open_view(Reader(ws), Address(page, more=choice, **fixed), SITES)
    assert view is not None
    return view


def filled(ws: Workspace, page: str, **choice: str) -> dict[str, Panel]:
    return {panel.name: panel for panel in pages()[page].fill(view_of(ws, page, **choice))}


def texts(part: object) -> list[str]:
    """All text within a component."""
    if isinstance(part, str):
        return [part]
    if isinstance(part, Component):
        return texts(getattr(part, "children", None))
    return [text for each in part for text in texts(each)] if isinstance(part, list | tuple) else []


def said(panel: Panel) -> str:
    return " ".join(texts(panel.content))


@pytest.mark.parametrize("page", NAMES)
@pytest.mark.parametrize("epoch", ["e0", "e1", "e2", "e3"])
def test_every_page_is_filled_for_every_state_of_an_epoch(campaign: Workspace, page: str, epoch: str) -> None:
    view = view_of(campaign, page, epoch=epoch)
    panels = pages()[page].fill(view)
    assert len({panel.name for panel in panels}) == len(panels)
    assert page_frame(view, pages()[page], panels)
    for panel in panels:
        assert panel.content is not None or panel.missing
        if panel.table is not None:
            assert panel.table.as_csv().startswith(str(panel.table.columns[0]))


def test_the_tables_of_schemes_say_what_the_rows_say(campaign: Workspace) -> None:
    panels = filled(campaign, "schemes", epoch="e1")
    tilt = tilt_row("e1", 1, (0.0071, -0.0057))
    assert f"{1e3 * tilt.deviation_m:.1f} ± 4.0" in said(panels["table-2"])
    assert f"{tilt.d_east:.8f}" in said(panels["table-2"])
    assert panels["table-3"].title == "Table 3: against F/paper"
    table = panels["table-1"].table
    assert table is not None
    assert table.rows == [["A", "paper", 5, 7, 0.0, 0.001, 0.0012, 4.9, None]]


def test_a_failed_scheme_is_a_row_with_its_reason_as_text(campaign: Workspace) -> None:
    panels = filled(campaign, "schemes", epoch="e2")
    assert f"no axis: {HOSTILE}" in texts(panels["table-1"].content)
    assert "--" in said(panels["table-2"])


def test_a_failed_epoch_has_one_panel_that_says_why_and_the_other_epochs_below(campaign: Workspace) -> None:
    panels = filled(campaign, "schemes", epoch="e3")
    assert HOSTILE in texts(panels["none"].content)
    assert "table-1" not in panels


def test_schemes_are_compared_with_what_the_address_says(campaign: Workspace) -> None:
    panels = filled(campaign, "schemes", epoch="e1", against="A/paper")
    assert panels["table-3"].title == "Table 3: against A/paper"
    with pytest.raises(UsageError, match="unknown scheme and method 'Z/z'"):
        filled(campaign, "schemes", against="Z/z")


def test_the_page_of_quality_says_what_follows(campaign: Workspace) -> None:
    panels = filled(campaign, "quality", epoch="e2")
    assert "2 of 2 stations entered the result" in said(panels["minds"])
    assert "A/paper has no covariance" in said(panels["minds"])
    assert f"-- {HOSTILE}" in texts(panels["stations"].content)
    assert panels["map"].note == "Without a position, as not used: ST02."
    assert filled(campaign, "quality", epoch="e3")["map"].missing == "no station has an adjusted position"
    assert "coverage" in filled(campaign, "quality", epoch="e1", coverage="stations")


def test_the_page_of_alarms_says_what_to_type(campaign: Workspace) -> None:
    panels = filled(campaign, "alarms")
    assert "tiltwatch acknowledge campaign.toml movement-e0 --name 'YOUR NAME' --note 'WHY'" in texts(
        panels["commands"].content
    )
    assert "measure again" in said(panels["rules"])
    assert HOSTILE in texts(panels["list"].content)
    assert "No alarm is closed, of this choice." in said(filled(campaign, "alarms", state="closed")["list"])


@pytest.mark.parametrize(("key", "value"), [("state", "x"), ("rule", "x"), ("alarm", "x")])
def test_filters_that_are_not_there_are_refused(campaign: Workspace, key: str, value: str) -> None:
    with pytest.raises(UsageError, match=r"unknown .*'x'; known: "):
        filled(campaign, "alarms", **{key: value})


def test_rules_of_a_structure_without_its_file_are_missing_with_the_reason(campaign: Workspace) -> None:
    view = open_view(Reader(campaign), Address("alarms"), {})
    assert view is not None
    panels = {panel.name: panel for panel in pages()["alarms"].fill(view)}
    assert "campaign file" in (panels["rules"].missing or "")
    assert "FILE is the campaign file" in (panels["commands"].note or "")


def test_the_page_of_runs_has_digests_and_a_link_for_every_table(campaign: Workspace) -> None:
    panels = filled(campaign, "runs", epoch="e0")
    assert epoch_row("e0").campaign_digest in said(panels["origin"])
    assert "5ca0" in said(panels["inputs"])
    assert "tilt.csv" in said(panels["downloads"])
    assert panels["timeline"].table is not None
    assert [row[0] for row in panels["timeline"].table.rows] == ["run-1"]
    assert (
        filled(campaign, "runs", epoch="e3")["timeline"].missing == "the ledger tells of no run of this epoch"
    )
    with pytest.raises(UsageError, match="unknown run 'x'; known: run-1"):
        filled(campaign, "runs", run="x")


def test_runs_are_read_by_structure_and_epoch(campaign: Workspace) -> None:
    assert [row.epoch for row in run_rows_of(campaign, STRUCTURE)] == ["e0", "e1"]
    assert [row.epoch for row in run_rows_of(campaign, STRUCTURE, "e1")] == ["e1"]
    assert run_rows_of(campaign, "another") == []


def test_whole_views_are_downloaded_by_structure(campaign: Workspace, tmp_path: Path) -> None:
    server = flask.Flask("test")
    serve_files(server, Reader(campaign), {})
    visitor = server.test_client()
    answer = visitor.get(f"/view/tilt.csv?structure={STRUCTURE}")
    assert answer.status_code == 200
    assert [line.split(",")[1] for line in answer.text.splitlines()[1:]] == ["e0", "e1", "e2"]
    assert answer.headers["Content-Disposition"] == f"attachment; filename={STRUCTURE}-tilt.csv"
    assert visitor.get("/view/tilt.csv?structure=x").status_code == 404
    assert visitor.get(f"/view/x.csv?structure={STRUCTURE}").status_code == 404
    empty = flask.Flask("empty")
    serve_files(empty, Reader(open_workspace(tmp_path / "empty")), {})
    assert empty.test_client().get(f"/view/tilt.csv?structure={STRUCTURE}").status_code == 404
