"""The ledger only grows, and a digest leads to the settings."""

from dataclasses import replace

import pytest

from storage.digests import text_sha256
from storage.errors import StorageError
from storage.ledger import append_run, kept_frame, read_settings, settings_path, store_settings
from storage.records import StageRunRow
from storage.views import rows_of
from storage.workspace import Workspace
from tests.storage.campaign import SETTINGS, STRUCTURE, stage_run_row


def test_runs_add_up(ws: Workspace) -> None:
    for run in ("run-1", "run-2"):
        path = append_run(ws, run, STRUCTURE, [stage_run_row(run, "e0")])
        assert path == ws.tables / "runs" / STRUCTURE / f"{run}.parquet"
    assert [row.run for row in rows_of(ws, StageRunRow)] == ["run-1", "run-2"]


def test_a_run_cannot_be_written_over(ws: Workspace) -> None:
    append_run(ws, "run-1", STRUCTURE, [stage_run_row("run-1", "e0")])
    with pytest.raises(StorageError, match="run run-1 of chimney-01 is in the ledger already"):
        append_run(ws, "run-1", STRUCTURE, [])


def test_a_row_of_another_run_is_refused(ws: Workspace) -> None:
    row = replace(stage_run_row("run-1", "e0"), run="run-2")
    with pytest.raises(StorageError, match="table runs, row 0: needed run run-1 of chimney-01, got run-2"):
        append_run(ws, "run-1", STRUCTURE, [row])


def test_a_digest_leads_to_the_settings(ws: Workspace) -> None:
    digest = text_sha256(SETTINGS)
    assert store_settings(ws, digest, SETTINGS) == ws.runs / "settings" / f"{digest}.json"
    store_settings(ws, digest, SETTINGS)
    assert read_settings(ws, digest) == SETTINGS


def test_settings_under_a_wrong_digest_are_refused(ws: Workspace) -> None:
    with pytest.raises(StorageError, match="settings need the SHA-256 of their text"):
        store_settings(ws, "0" * 64, SETTINGS)


def test_damaged_settings_are_told_and_healed(ws: Workspace) -> None:
    digest = text_sha256(SETTINGS)
    store_settings(ws, digest, SETTINGS)
    settings_path(ws, digest).write_text("{}")
    with pytest.raises(StorageError, match="is damaged"):
        read_settings(ws, digest)
    store_settings(ws, digest, SETTINGS)
    assert read_settings(ws, digest) == SETTINGS


def test_absent_settings_are_told(ws: Workspace) -> None:
    with pytest.raises(StorageError, match="no settings with digest ab"):
        read_settings(ws, "ab")


def test_the_frame_of_kept_settings_is_found_by_their_digest(ws: Workspace) -> None:
    text = '{"frame": {"axes": "NEU"}}'
    store_settings(ws, text_sha256(text), text)
    store_settings(ws, text_sha256(SETTINGS), SETTINGS)
    assert kept_frame(ws, text_sha256(text)) == {"axes": "NEU"}
    assert kept_frame(ws, text_sha256(SETTINGS)) is None
    assert kept_frame(ws, "0" * 64) is None
