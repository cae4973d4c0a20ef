"""Verification finds what was damaged, and nothing where nothing was."""

import os
import shutil
import threading

import duckdb
import numpy as np
import pytest

from storage.artifacts import artifact_path, put_array
from storage.assessed import put_down_assessed
from storage.catalog import rebuild_catalog
from storage.publish import publish_epoch
from storage.run_record import held_record, record_of_this_process
from storage.series import publish_series
from storage.tables import EPOCH_TABLES, SERIES, SERIES_TABLES, table_path
from storage.verify import Fault, VerifyReport, verify_workspace, verify_workspace_deeply
from storage.workspace import Workspace, open_workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, fill


@pytest.fixture
def filled(ws: Workspace) -> Workspace:
    fill(ws)
    rebuild_catalog(ws)
    put_array(ws, "cloud", np.arange(6.0))
    return ws


def only_fault(report: VerifyReport) -> Fault:
    assert len(report.faults) == 1, report.faults
    return report.faults[0]


def test_an_empty_workspace_has_no_faults(ws: Workspace) -> None:
    assert verify_workspace(ws).faults == ()


def test_a_whole_workspace_has_no_faults(filled: Workspace) -> None:
    for report in (verify_workspace(filled), verify_workspace_deeply(filled)):
        assert report.faults == ()
        assert report.checked > 20


def test_a_whole_workspace_that_was_moved_needs_its_catalog_only(filled: Workspace) -> None:
    moved = open_workspace(filled.root.with_name("moved"))
    shutil.copytree(filled.root, moved.root, dirs_exist_ok=True)
    rebuild_catalog(moved)
    assert verify_workspace(moved).faults == ()


def test_a_flipped_byte_of_an_artifact_is_found(filled: Workspace) -> None:
    path = artifact_path(filled, put_array(filled, "cloud", np.arange(6.0)))
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    assert "does not have the digest" in only_fault(verify_workspace(filled)).what


def test_a_byte_flipped_behind_an_unchanged_time_is_found_by_the_deep_form(filled: Workspace) -> None:
    path = artifact_path(filled, put_array(filled, "cloud", np.arange(6.0)))
    stat = path.stat()
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert "does not have the digest" in only_fault(verify_workspace_deeply(filled)).what


def test_a_stranger_among_the_artifacts_is_found(filled: Workspace) -> None:
    (filled.artifacts / "ab").mkdir(exist_ok=True)
    (filled.artifacts / "ab" / "notes.txt").touch()
    assert only_fault(verify_workspace(filled)).where == "artifacts/ab/notes.txt"


def test_a_damaged_table_is_found(filled: Workspace) -> None:
    path = table_path(filled, "tilt", STRUCTURE, "e1")
    content = path.read_bytes()
    path.write_bytes(content[:-30] + b"x" * 22 + content[-8:])
    faults = verify_workspace(filled).faults
    assert faults[0].where == f"tables/tilt/{STRUCTURE}/e1.parquet"
    assert "run the epoch again" in faults[0].what_to_do


@pytest.mark.parametrize("table", SERIES_TABLES)
def test_series_that_are_not_what_was_assessed_are_found(filled: Workspace, table: str) -> None:
    publish_series(filled, STRUCTURE, {name: [] for name in SERIES_TABLES})
    put_down_assessed(filled, STRUCTURE, "basis")
    rebuild_catalog(filled)
    whole = verify_workspace(filled)
    assert (whole.faults, [note for note in whole.notes if "series" in note.what]) == ((), [])
    path = table_path(filled, table, STRUCTURE, SERIES)
    stat, content = path.stat(), bytearray(path.read_bytes())
    content[-12] ^= 1  # in the last words of the file, which no checksum of a page covers
    path.write_bytes(content)
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert "is not what was made of the epochs" in {fault.what for fault in verify_workspace(filled).faults}
    path.unlink()
    assert "is gone" in {fault.what for fault in verify_workspace(filled).faults}


def test_series_that_changed_without_a_new_mark_are_noted_and_no_fault(filled: Workspace) -> None:
    put_down_assessed(filled, STRUCTURE, "basis")
    publish_series(filled, STRUCTURE, {name: [] for name in SERIES_TABLES})  # as if the run was killed here
    rebuild_catalog(filled)
    report = verify_workspace(filled)
    assert report.faults == ()
    assert [note.where for note in report.notes if "its series" in note.what] == [STRUCTURE]


def test_an_epoch_with_a_table_missing_is_found(filled: Workspace) -> None:
    table_path(filled, "axis_parameters", STRUCTURE, "e1").unlink()
    faults = verify_workspace(filled).faults
    assert any(
        "the epoch is not whole" in fault.what and fault.where == f"{STRUCTURE}/e1" for fault in faults
    )


def test_rows_under_a_wrong_name_are_found(filled: Workspace) -> None:
    shutil.copy(table_path(filled, "tilt", STRUCTURE, "e0"), table_path(filled, "tilt", STRUCTURE, "e1"))
    assert f"holds rows of {STRUCTURE}/e0" in {fault.what for fault in verify_workspace(filled).faults}


def test_missing_settings_are_found(filled: Workspace) -> None:
    next((filled.runs / "settings").iterdir()).unlink()
    faults = verify_workspace(filled).faults
    assert ["no settings with digest" in fault.what for fault in faults] == [True, True, False]
    assert faults[2].what == "is gone"


def test_a_catalog_that_follows_a_run_under_way_is_worth_a_word_only(filled: Workspace) -> None:
    with held_record(filled, record_of_this_process("r9", STRUCTURE, "own")):
        publish_epoch(filled, STRUCTURE, "e2", epoch_tables("e2", 2))
        report = verify_workspace(filled)
        assert report.faults == ()
        assert [note.where for note in report.notes if "a run is under way" in note.what] == [
            "catalog.duckdb"
        ]
        filled.catalog.write_bytes(b"x")
        assert any(fault.where == "catalog.duckdb" for fault in verify_workspace(filled).faults)


def test_a_catalog_that_is_just_brought_up_to_date_is_waited_for(filled: Workspace) -> None:
    publish_epoch(filled, STRUCTURE, "e2", epoch_tables("e2", 2))
    soon = threading.Timer(0.3, rebuild_catalog, [filled])
    soon.start()
    try:
        assert not [fault for fault in verify_workspace(filled).faults if fault.where == "catalog.duckdb"]
    finally:
        soon.join()


def test_a_catalog_behind_the_tables_is_found(filled: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("storage.verify.CATCH_UP_S", 0.1)
    publish_epoch(filled, STRUCTURE, "e2", epoch_tables("e2", 2))
    faults = verify_workspace(filled).faults
    assert any("older than the tables" in fault.what for fault in faults)
    assert any("shows 2 rows of tilt; the tables hold 3" in fault.what for fault in faults)


def test_a_catalog_that_someone_wrote_to_is_found(filled: Workspace) -> None:
    with duckdb.connect(str(filled.catalog)) as connection:
        connection.execute("DELETE FROM data.tilt WHERE epoch = 'e1'")
    assert only_fault(verify_workspace(filled)).what == "shows 1 rows of tilt; the tables hold 2"


def test_a_publication_cut_short_is_found_with_its_temps(filled: Workspace) -> None:
    def stop(step: str) -> None:
        if step == "journal":
            raise InterruptedError

    with pytest.raises(InterruptedError):
        publish_epoch(filled, STRUCTURE, "e2", epoch_tables("e2", 2), after_step=stop)
    faults = verify_workspace(filled).faults
    assert faults[0].where == "publish-journal.json"
    assert len(faults) == 1 + len(EPOCH_TABLES) + 1, "the journal, the temps of the tables and of the seal"
    rebuild_catalog(filled)
    assert verify_workspace(filled).faults == ()
