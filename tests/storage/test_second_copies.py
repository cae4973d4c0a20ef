"""What cannot be made again is kept twice: either copy mends the other; what is lost in both is said and stops nobody."""

import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from storage.alarm_log import append_alarm_event
from storage.archive import archive_version
from storage.catalog import rebuild_catalog
from storage.errors import StorageError
from storage.intake import write_intake
from storage.ledger import append_run
from storage.mend import losses, mend_copies
from storage.publish import publish_epoch
from storage.records import AlarmEventRow
from storage.second_copies import second_path
from storage.tables import table_path
from storage.verify import verify_workspace
from storage.views import rows_of
from storage.workspace import Workspace
from tests.faults.damages import DAMAGES, Damage, flip
from tests.faults.kinds import kinds_of, names_in
from tests.storage.campaign import STRUCTURE, alarm_event_row, epoch_tables, fill, stage_run_row

KEPT_TWICE = (
    f"tables/alarm_events/{STRUCTURE}/a1.parquet",
    f"tables/runs/{STRUCTURE}/r1.parquet",
    f"intake/{STRUCTURE}/e1.toml",
    f"versions/{STRUCTURE}/old/e1/manifest.json",
    "workspace.json",
)

ONE = {name: damage for name, damage in DAMAGES.items() if name != "exchanged"}


@pytest.fixture
def full(ws: Workspace) -> Workspace:
    fill(ws)
    archive_version(ws, STRUCTURE, "old", ["e0", "e1"], "for the test")
    append_alarm_event(ws, alarm_event_row("a1"))
    append_alarm_event(ws, alarm_event_row("a2", "acknowledged", 1))
    if not (ws.tables / "runs" / STRUCTURE / "r1.parquet").exists():
        append_run(ws, "r1", STRUCTURE, [stage_run_row("r1", "e0")])
    write_intake(ws, STRUCTURE, "e1", 'epoch = "e1"\ntime = 2025-04-14T06:00:00Z\n')
    rebuild_catalog(ws)
    return ws


def test_every_file_of_a_workspace_is_of_one_known_kind(full: Workspace) -> None:
    assert {name: len(kinds_of(name)) for name in names_in(full.root) if len(kinds_of(name)) != 1} == {}


def test_a_whole_workspace_needs_no_mending(full: Workspace) -> None:
    assert mend_copies(full) == []
    assert verify_workspace(full).faults == verify_workspace(full).notes == ()


@pytest.mark.parametrize("damage", ONE.values(), ids=ONE)
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, id=kind, marks=() if kind in ("event", "intake") else pytest.mark.slow)
        for name, kind in zip(KEPT_TWICE, ("event", "ledger", "intake", "manifest", "identity"), strict=True)
    ],
)
def test_a_damaged_first_copy_is_found_and_put_back(full: Workspace, name: str, damage: Damage) -> None:
    path = full.root / name
    before = path.read_bytes()
    damage(path, None)
    assert name in {fault.where for fault in verify_workspace(full).faults}
    (told,) = mend_copies(full)
    assert (told.where, told.is_lost) == (name, False)
    if "changed by hand" not in told.what:
        assert path.read_bytes() == before
    assert mend_copies(full) == []


@pytest.mark.parametrize("damage", ONE.values(), ids=ONE)
def test_a_damaged_second_copy_is_made_anew(full: Workspace, damage: Damage) -> None:
    path = full.root / KEPT_TWICE[0]
    before = second_path(full, path).read_bytes()
    damage(second_path(full, path), None)
    report = verify_workspace(full)
    assert KEPT_TWICE[0] in {told.where for told in (*report.faults, *report.notes)}
    mend_copies(full)
    assert second_path(full, path).read_bytes() == before


@pytest.mark.parametrize("name", KEPT_TWICE[:3], ids=["event", "ledger", "intake"])
def test_what_is_lost_in_both_copies_is_said_and_stops_no_catalog(full: Workspace, name: str) -> None:
    for path in (full.root / name, second_path(full, full.root / name)):
        path.write_bytes(b"x")
    assert "cannot be made again" in next(
        fault.what_to_do
        for fault in verify_workspace(full).faults
        if fault.where == name and "second" in fault.what
    )
    (told,) = mend_copies(full)
    assert told.is_lost and "restore it from a backup" in told.what
    rebuild_catalog(full)
    assert any(".bad" in told.where for told in verify_workspace(full).notes)


def test_one_event_exchanged_for_another_is_put_back(full: Workspace) -> None:
    DAMAGES["exchanged"](full.root / KEPT_TWICE[0], full.root / KEPT_TWICE[0].replace("a1", "a2"))
    mend_copies(full)
    rebuild_catalog(full)
    assert [row.event for row in rows_of(full, AlarmEventRow)] == ["a1", "a2"]


@pytest.mark.parametrize(
    ("name", "other"),
    [
        (KEPT_TWICE[0], KEPT_TWICE[0].replace("a1", "a2")),
        (KEPT_TWICE[1], KEPT_TWICE[0]),
        (KEPT_TWICE[2], KEPT_TWICE[3]),
        (KEPT_TWICE[3], KEPT_TWICE[3].replace("e1", "e0")),
        (KEPT_TWICE[4], KEPT_TWICE[0]),
    ],
    ids=["event", "ledger", "intake", "manifest", "identity"],
)
def test_the_second_copy_of_another_file_does_not_take_the_place_of_a_whole_one(
    full: Workspace, name: str, other: str
) -> None:
    path = full.root / name
    before, second = path.read_bytes(), second_path(full, path).read_bytes()
    DAMAGES["exchanged"](second_path(full, path), second_path(full, full.root / other))
    assert name in {fault.where for fault in verify_workspace(full).faults}
    (told,) = mend_copies(full)
    assert (told.where, told.is_lost, path.read_bytes()) == (name, False, before)
    assert second_path(full, path).read_bytes() == second


def test_the_second_copy_of_another_file_does_not_stand_for_one_that_is_gone(full: Workspace) -> None:
    path = full.root / KEPT_TWICE[0]
    DAMAGES["exchanged"](second_path(full, path), second_path(full, path.with_name("a2.parquet")))
    path.unlink()
    (told,) = mend_copies(full)
    assert (told.is_lost, path.exists()) == (True, False)


def test_a_folder_for_temporary_files_that_is_full_says_so_and_nothing_is_touched(
    full: Workspace, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = full.root / KEPT_TWICE[0]
    path.unlink()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    with pytest.raises(StorageError, match=r"cannot write .*none: .*put that right"):
        mend_copies(full)
    assert not path.exists()


def test_earlier_results_that_are_gone_with_their_folder_are_said(full: Workspace) -> None:
    folder = (full.root / KEPT_TWICE[3]).parent
    for path in folder.iterdir():
        path.unlink()
    folder.rmdir()
    assert KEPT_TWICE[3] in {fault.where for fault in verify_workspace(full).faults}
    assert [told.is_lost for told in mend_copies(full)] == [True]


def altered(path: Path) -> None:
    """A whole table with other numbers, as a hand or another program writes it."""
    other = path.with_name("e0.parquet")
    path.write_bytes(other.read_bytes())


@pytest.mark.parametrize(
    "spoil", [lambda path: flip(path, None), altered, Path.unlink], ids=["flipped", "altered", "deleted"]
)
def test_a_table_that_is_not_what_was_published_is_found_and_published_again(
    full: Workspace, spoil: Callable[[Path], None]
) -> None:
    path = table_path(full, "slices", STRUCTURE, "e1")
    before = path.read_bytes()
    spoil(path)
    assert f"tables/slices/{STRUCTURE}/e1.parquet" in {fault.where for fault in verify_workspace(full).faults}
    assert publish_epoch(full, STRUCTURE, "e1", epoch_tables("e1", 1, (0.007 + 1e-4, -0.0057)))
    assert path.read_bytes() == before
    rebuild_catalog(full)
    assert [fault for fault in verify_workspace(full).faults if "seal" in fault.what] == []


def test_a_published_table_that_nobody_makes_again_is_said_after_the_run(full: Workspace) -> None:
    assert losses(full) == []
    table_path(full, "slices", STRUCTURE, "e1").unlink()
    table_path(full, "tilt", STRUCTURE, "e0").write_bytes(b"PAR1")
    rebuild_catalog(full)
    told = {loss.where: loss.what for loss in losses(full)}
    assert "was published and is gone" in told[f"tables/slices/{STRUCTURE}/e1.parquet"]
    assert "left out of the catalog" in told[f"tables/tilt/{STRUCTURE}/e0.parquet"]


def test_an_epoch_of_an_older_program_is_noted_and_gets_its_seal(full: Workspace) -> None:
    (seal,) = full.seals.glob("*/e1.json")
    before = seal.read_bytes()
    seal.unlink()
    report = verify_workspace(full)
    assert (report.faults, len(report.notes)) == ((), 1)
    assert not publish_epoch(full, STRUCTURE, "e1", epoch_tables("e1", 1, (0.007 + 1e-4, -0.0057)))
    assert seal.read_bytes() == before


def test_a_damaged_seal_is_named_and_not_the_tables(full: Workspace) -> None:
    (seal,) = full.seals.glob("*/e1.json")
    os.truncate(seal, 80)
    assert [fault.where for fault in verify_workspace(full).faults] == [f"seals/{STRUCTURE}/e1.json"]


@pytest.mark.parametrize("number", [errno.EIO, errno.EACCES, errno.ESTALE])
@pytest.mark.parametrize("reader", ["read_bytes", "read_rows"])
def test_a_file_that_the_drive_does_not_give_for_a_moment_is_not_taken_for_damaged(
    full: Workspace, monkeypatch: pytest.MonkeyPatch, reader: str, number: int
) -> None:
    path = full.root / KEPT_TWICE[0]
    copies = [path.read_bytes(), second_path(full, path).read_bytes()]
    read_bytes, fault = Path.read_bytes, OSError(number, os.strerror(number))

    def refused(self: Path) -> bytes:
        if self.name == path.name and (reader == "read_bytes" or self != path):
            raise fault
        return read_bytes(self)

    def refused_rows(*_what: object) -> list[object]:
        raise StorageError("cannot read") from fault

    with monkeypatch.context() as away:
        if reader == "read_bytes":
            away.setattr(Path, "read_bytes", refused)
        else:
            second_path(full, path).write_bytes(b"x")
            away.setattr("storage.second_copies.read_rows", refused_rows)
        with pytest.raises(StorageError, match=r"cannot read .* nothing of it was touched"):
            mend_copies(full)
    if reader == "read_rows":
        mend_copies(full)
    assert [path.read_bytes(), second_path(full, path).read_bytes()] == copies


def test_what_is_lost_in_both_copies_stays_beside_for_a_person_to_look_at(full: Workspace) -> None:
    path = full.root / KEPT_TWICE[0]
    stored = second_path(full, path).read_bytes()
    second_path(full, path).write_bytes(b"0" + stored[1:])  # in the digest: what is behind it is whole
    path.write_bytes(b"x")
    assert [told.is_lost for told in mend_copies(full)] == [True]
    (left,) = second_path(full, path).parent.glob(f"{path.name}*.bad")
    assert left.read_bytes()[65:] == stored[65:]


def test_an_edit_by_hand_that_cannot_be_read_is_kept_beside(full: Workspace) -> None:
    path = full.root / KEPT_TWICE[2]
    path.write_text('epoch = "e1"\nheading_deg = 12,5\n')
    (told,) = mend_copies(full)
    (left,) = path.parent.glob("*.bad")
    assert "12,5" in left.read_text()
    assert left.name in told.what


def test_earlier_results_that_are_gone_are_told_once(full: Workspace, tmp_path: Path) -> None:
    (full.versions / STRUCTURE).rename(tmp_path / "elsewhere")
    assert mend_copies(full) != []
    assert mend_copies(full) == []


def test_what_another_process_has_just_published_is_not_lost(full: Workspace) -> None:
    publish_epoch(full, STRUCTURE, "e1", epoch_tables("e1", 1, (0.009, -0.005)))
    assert losses(full) == []
