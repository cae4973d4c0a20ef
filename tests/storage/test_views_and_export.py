"""The typed reading functions and the exports say what was published."""

import csv
import io
import json
from datetime import timedelta
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from storage import views
from storage.alarm_log import append_alarm_event
from storage.catalog import rebuild_catalog
from storage.errors import StorageError, UsageError
from storage.export import FORMATS, export_view
from storage.publish import publish_epoch
from storage.records import SectionFit, columns_of
from storage.view_definitions import VIEWS
from storage.workspace import Workspace, open_workspace
from tests.storage.campaign import STRUCTURE, alarm_event_row, epoch_tables, epoch_time, fill


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """One workspace for all tests here, which only read it."""
    ws = open_workspace(tmp_path_factory.mktemp("filled"))
    fill(ws, 3)
    rebuild_catalog(ws)
    return ws


def exported(ws: Workspace, view: str, file_format: str) -> bytes:
    out = io.BytesIO()
    export_view(ws, view, file_format, out)
    return out.getvalue()


def test_each_reading_function_gives_the_published_rows(filled: Workspace) -> None:
    tables = epoch_tables("e1", 1, (0.0071, -0.0057))
    assert views.epoch_rows(filled, STRUCTURE)[1:2] == tables["epochs"]
    assert views.station_rows(filled, STRUCTURE, "e1") == tables["stations"]
    assert views.pair_rows(filled, STRUCTURE, "e1") == tables["pairs"]
    assert views.removal_rows(filled, STRUCTURE, "e1") == tables["removals"]
    assert views.coverage_rows(filled, STRUCTURE, "e1") == tables["coverage"]
    assert views.surface_map_rows(filled, STRUCTURE, "e1") == tables["surface_map"]
    assert views.slice_rows(filled, STRUCTURE, "e1", "A", "paper") == tables["slices"]
    assert views.tilt_rows(filled, STRUCTURE, "e1") == tables["tilt"]
    assert views.scheme_rows(filled, STRUCTURE, "e1") == tables["schemes"]
    assert views.accuracy_rows(filled, STRUCTURE, "e1") == tables["accuracy"]
    assert views.reference_lean_rows(filled, STRUCTURE, "e1") == tables["reference_leans"]
    assert views.scheme_comparison_rows(filled, STRUCTURE, "e1") == tables["scheme_comparison"]
    assert views.alarm_rows(filled, STRUCTURE) == []
    assert [row.epoch for row in views.run_rows(filled, "run-1")] == ["e0", "e1", "e2"]
    assert [row.epoch for row in views.tilt_rows(filled, STRUCTURE)] == ["e0", "e1", "e2"]


def test_the_latest_epoch_is_the_newest_by_time_not_by_name(ws: Workspace) -> None:
    publish_epoch(ws, STRUCTURE, "z-old", epoch_tables("z-old", 0))
    publish_epoch(ws, STRUCTURE, "a-new", epoch_tables("a-new", 1, state="failed"))
    rebuild_catalog(ws)
    assert [(row.epoch, row.state) for row in views.latest_epochs(ws)] == [("a-new", "failed")]


def test_rows_of_what_is_no_table_are_refused(ws: Workspace) -> None:
    with pytest.raises(UsageError, match="SectionFit is not stored as a table; known: epochs"):
        views.rows_of(ws, SectionFit)


@pytest.mark.parametrize("file_format", FORMATS)
@pytest.mark.parametrize("view", VIEWS)
def test_every_view_exports_the_same_bytes_each_time(filled: Workspace, view: str, file_format: str) -> None:
    assert exported(filled, view, file_format) == exported(filled, view, file_format)


def test_csv_has_a_header_iso_times_and_empty_nulls(filled: Workspace) -> None:
    rows = list(csv.DictReader(io.StringIO(exported(filled, "epochs", "csv").decode())))
    assert [row["epoch"] for row in rows] == ["e0", "e1", "e2"]
    assert rows[0]["epoch_time"] == "2025-03-13T22:00:00.123456Z"
    assert rows[0]["reason"] == ""
    assert rows[0]["is_reference"] == "true"


def test_csv_floats_read_back_the_same(filled: Workspace) -> None:
    rows = csv.DictReader(io.StringIO(exported(filled, "tilt", "csv").decode()))
    assert [float(row["tilt_deg"]) for row in rows] == [
        row.tilt_deg for row in views.tilt_rows(filled, STRUCTURE)
    ]


def test_json_is_an_array_of_objects(filled: Workspace) -> None:
    rows = json.loads(exported(filled, "changes", "json"))
    assert [row["d_top_m"] for row in rows] == [row.d_top_m for row in views.change_rows(filled, STRUCTURE)]


def test_parquet_keeps_units(filled: Workspace) -> None:
    schema = pq.read_schema(io.BytesIO(exported(filled, "changes", "parquet")))
    assert schema.names == [field.name for field in columns_of(VIEWS["changes"])]
    assert schema.field("d_top_m").metadata[b"unit"] == b"m"


def test_an_export_to_a_path_is_whole(filled: Workspace, tmp_path: Path) -> None:
    export_view(filled, "tilt", "csv", tmp_path / "out" / "tilt.csv")
    assert (tmp_path / "out" / "tilt.csv").read_bytes() == exported(filled, "tilt", "csv")


@pytest.mark.parametrize(
    ("view", "file_format", "message"),
    [
        ("tilts", "csv", "unknown view 'tilts'; known: epochs"),
        ("tilt", "xlsx", "unknown export format 'xlsx'; known: csv"),
    ],
)
def test_a_wrong_word_is_answered_with_the_known_ones(
    filled: Workspace, view: str, file_format: str, message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        exported(filled, view, file_format)


def test_alarm_is_what_its_events_have_made_of_it(ws: Workspace) -> None:
    append_alarm_event(ws, alarm_event_row("20250101T000000Z-a"))
    append_alarm_event(ws, alarm_event_row("20250101T010000Z-b", "acknowledged", hours=1))
    append_alarm_event(ws, alarm_event_row("20250101T020000Z-c", "delivered", hours=2))
    rebuild_catalog(ws)
    (alarm,) = views.alarm_rows(ws, STRUCTURE, "e0")
    assert (alarm.state, alarm.person, alarm.note) == ("acknowledged", "A. Surveyor", "seen")
    assert (alarm.raised_at, alarm.changed_at) == (epoch_time(0), epoch_time(0) + timedelta(hours=1))
    assert len(views.alarm_event_rows(ws, STRUCTURE)) == 3


def test_log_of_alarms_is_append_only(ws: Workspace) -> None:
    append_alarm_event(ws, alarm_event_row("one"))
    with pytest.raises(StorageError, match="append only"):
        append_alarm_event(ws, alarm_event_row("one", "closed"))
