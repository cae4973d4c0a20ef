"""A drive that is full, read-only or gone: a clear error, old results intact, and the next try ends as undisturbed."""

import errno
import os
import resource
from collections.abc import Iterator
from pathlib import Path

import pytest

from storage.alarm_log import append_alarm_event
from storage.atomic import write_atomically
from storage.backup import ArchiveRequest, CampaignFile, restore_archive, write_archive
from storage.catalog import rebuild_catalog
from storage.errors import StorageError
from storage.ledger import append_run
from storage.publish import publish_epoch, recover, stale_temps
from storage.records import TABLES, TiltRow
from storage.tables import EPOCH_TABLES, table_path
from storage.upgrade import ready_workspace
from storage.verify import verify_workspace
from storage.views import rows_of, tilt_rows
from storage.workspace import Workspace, existing_workspace, open_workspace
from tests.faults.small_drive import Drive, may_mount, small_drive
from tests.storage.campaign import STRUCTURE, alarm_event_row, epoch_tables, fill, stage_run_row
from tests.storage.stored_workspaces import FIRST, unpacked

KIB = 1024
NEW = (0.008, -0.0057)


@pytest.fixture
def drive(tmp_path: Path) -> Iterator[Drive]:
    why_not = may_mount(tmp_path / "try")
    if why_not:
        pytest.skip(f"no drive can be mounted here ({why_not}); test_a_write_beyond_a_limit stands for it")
    with small_drive(tmp_path / "drive", 24) as mounted:
        yield mounted


@pytest.fixture
def stored(drive: Drive) -> Workspace:
    ws = open_workspace(drive.place / "ws")
    fill(ws)
    rebuild_catalog(ws)
    return ws


def do_everything(ws: Workspace) -> None:
    """Publish an epoch anew, append to both ledgers, rebuild the catalog; what is done already stays."""
    publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1, NEW))
    if not table_path(ws, "alarm_events", STRUCTURE, "a1").exists():
        append_alarm_event(ws, alarm_event_row("a1"))
    if not table_path(ws, "runs", STRUCTURE, "run-2").exists():
        append_run(ws, "run-2", STRUCTURE, [stage_run_row("run-2", "e1")])
    rebuild_catalog(ws)


def content(ws: Workspace) -> dict[str, list[object]]:
    return {table: list(rows_of(ws, TABLES[table])) for table in TABLES}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[object]]:
    ws = open_workspace(tmp_path_factory.mktemp("undisturbed") / "ws")
    fill(ws)
    do_everything(ws)
    return content(ws)


@pytest.mark.parametrize(
    "free_kib", [16, *(pytest.param(kib, marks=pytest.mark.slow) for kib in (0, 96, 320, 1024))]
)
def test_a_full_drive_is_told_and_what_is_stored_stays_readable_and_the_next_try_ends_as_undisturbed(
    drive: Drive, stored: Workspace, undisturbed: dict[str, list[object]], free_kib: int
) -> None:
    before = content(stored)
    drive.fill_up(free_kib * KIB)
    with pytest.raises(StorageError, match=r"No space left.*(free space|space on the drive)"):
        do_everything(stored)
    left = content(stored)
    assert {table: left[table] for table in EPOCH_TABLES} in [
        {table: whole[table] for table in EPOCH_TABLES} for whole in (before, undisturbed)
    ], "an epoch is the old one or the new one"
    assert len(tilt_rows(stored, STRUCTURE)) == len(before["tilt"]), "the catalog is there"
    drive.empty()
    do_everything(stored)
    assert content(stored) == undisturbed
    assert (stale_temps(stored), verify_workspace(stored).faults) == ([], ())


def test_a_drive_that_became_read_only_is_told_and_everything_can_be_read(
    drive: Drive, stored: Workspace
) -> None:
    before = tilt_rows(stored, STRUCTURE)
    drive.read_only()
    with pytest.raises(StorageError, match=r"cannot write .*Read-only file system"):
        do_everything(stored)
    assert tilt_rows(existing_workspace(stored.root), STRUCTURE) == before
    assert verify_workspace(stored).faults == ()
    drive.writable()
    do_everything(stored)
    assert verify_workspace(stored).faults == ()


def test_a_read_only_workspace_of_an_earlier_version_is_read_and_can_be_archived(
    drive: Drive, tmp_path: Path
) -> None:
    place = unpacked(FIRST, drive.place)
    drive.read_only()
    ws = ready_workspace(place)
    assert len(tilt_rows(ws, "demo-chimney")) > 0
    campaign = CampaignFile(place / "campaign.toml", "campaign.toml")
    write_archive(ws, ArchiveRequest(campaign), tmp_path / "rescued.tar")
    restored = restore_archive(tmp_path / "rescued.tar", tmp_path / "rescued")
    assert tilt_rows(Workspace(restored.workspace), "demo-chimney") == tilt_rows(ws, "demo-chimney")


def test_a_write_beyond_a_limit_of_the_system_is_told_and_leaves_the_old_file(tmp_path: Path) -> None:
    """It stands for a full drive where none can be mounted: the system refuses in the middle of a file."""
    path = tmp_path / "table.parquet"
    write_atomically(path, b"old")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
    try:
        with pytest.raises(StorageError, match=r"cannot write .*File too large; put that right"):
            write_atomically(path, bytes(100_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert [(each.name, each.read_bytes()) for each in tmp_path.iterdir()] == [("table.parquet", b"old")]


def test_a_stale_handle_of_a_network_drive_is_told_and_the_next_try_ends_well(
    ws: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(ws)
    rebuild_catalog(ws)
    with monkeypatch.context() as away:
        away.setattr(os, "fsync", _stale)
        with pytest.raises(StorageError, match=r"cannot write .*Stale file handle"):
            publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1, NEW))
    recover(ws)
    assert {row.lean_east for row in rows_of(ws, TiltRow)} == {0.007, 0.007 + 1e-4}
    do_everything(ws)
    assert verify_workspace(ws).faults == ()


def _stale(_handle: int) -> None:
    raise OSError(errno.ESTALE, os.strerror(errno.ESTALE))
