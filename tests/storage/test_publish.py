"""An epoch is published whole or not at all, wherever the machine stops."""

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from storage.errors import InputError, StorageError
from storage.publish import publish_epoch, recover, remove_epoch, stale_temps
from storage.records import TABLES, ChangeTestRow, SliceRow, TiltRow
from storage.tables import EPOCH_TABLES, EpochKey, epochs_on_disk, files_of, table_path
from storage.views import rows_of
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, fill, tilt_row

OLD, NEW = (0.007, -0.0057), (0.008, -0.0057)
N_STEPS = 2 * (len(EPOCH_TABLES) + 1) + 2

CRASH = """
import os, sys
from pathlib import Path
from storage.publish import publish_epoch
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables
done = []
def step(name):
    done.append(name)
    if len(done) == int(sys.argv[2]):
        os._exit(9)
publish_epoch(Workspace(Path(sys.argv[1])), STRUCTURE, "e0", epoch_tables("e0", 0, (0.008, -0.0057), state="degraded"),
              after_step=step)
"""


class Crash(Exception):  # noqa: N818 - it stands for a power cut, not for an error
    pass


def crash_after(count: int) -> Callable[[str], None]:
    done: list[str] = []

    def step(name: str) -> None:
        done.append(name)
        if len(done) == count:
            raise Crash(name)

    return step


def stored(ws: Workspace) -> dict[str, list[object]]:
    return {table: list(rows_of(ws, TABLES[table])) for table in EPOCH_TABLES}


def publish_old(ws: Workspace) -> None:
    publish_epoch(ws, STRUCTURE, "e0", epoch_tables("e0", 0, OLD))


def new_tables() -> dict[str, list[object]]:
    tables = epoch_tables("e0", 0, NEW, state="degraded")
    return {**tables, "accuracy": [], "slices": tables["slices"][:3]}


def utc(tables: dict[str, list[object]]) -> dict[str, list[object]]:
    return {table: list(tables[table]) for table in EPOCH_TABLES}


def test_what_was_published_is_there(ws: Workspace) -> None:
    assert publish_epoch(ws, STRUCTURE, "e0", new_tables())
    assert stored(ws) == utc(new_tables())
    assert not ws.journal.exists()
    assert stale_temps(ws) == []


def test_there_is_one_file_a_table_structure_and_epoch(ws: Workspace) -> None:
    publish_old(ws)
    found = {path.relative_to(ws.tables).as_posix() for path in ws.tables.rglob("*") if path.is_file()}
    assert found == {f"{table}/{STRUCTURE}/e0.parquet" for table in EPOCH_TABLES}


@pytest.mark.parametrize("count", range(1, N_STEPS + 1))
@pytest.mark.parametrize("before", ["published", "absent"])
def test_after_a_crash_at_any_step_the_epoch_is_old_or_new_and_whole(
    ws: Workspace, count: int, before: str
) -> None:
    if before == "published":
        publish_old(ws)
    old = stored(ws)
    with pytest.raises(Crash):
        publish_epoch(ws, STRUCTURE, "e0", new_tables(), after_step=crash_after(count))
    recover(ws)
    journal_written = count > len(EPOCH_TABLES) + 1  # behind the temps of the tables and of the seal
    assert stored(ws) == (utc(new_tables()) if journal_written else old)
    assert not ws.journal.exists()
    assert stale_temps(ws) == []
    assert not publish_epoch(ws, STRUCTURE, "e0", new_tables()) or not journal_written


@pytest.mark.parametrize("count", [3, len(EPOCH_TABLES) + 1, len(EPOCH_TABLES) + 4])
def test_a_process_that_dies_in_the_middle_leaves_a_whole_epoch(ws: Workspace, count: int) -> None:
    publish_old(ws)
    died = subprocess.run([sys.executable, "-c", CRASH, str(ws.root), str(count)], check=False)
    assert died.returncode == 9
    recover(ws)
    leans = {row.lean_east for row in rows_of(ws, TiltRow)}
    states = {row.state for row in rows_of(ws, TABLES["epochs"])}
    assert (leans, states) in [({0.007}, {"ok"}), ({0.008}, {"degraded"})]


@pytest.mark.parametrize("count", range(1, len(EPOCH_TABLES) + 3))
def test_a_removal_cut_short_is_finished(ws: Workspace, count: int) -> None:
    publish_old(ws)
    with pytest.raises(Crash):
        remove_epoch(ws, STRUCTURE, "e0", after_step=crash_after(count))
    recover(ws)
    assert epochs_on_disk(ws) == []


def test_a_removed_epoch_is_gone_and_the_others_stay(ws: Workspace) -> None:
    publish_old(ws)
    publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1))
    assert remove_epoch(ws, STRUCTURE, "e0")
    assert epochs_on_disk(ws) == [EpochKey(STRUCTURE, "e1")]
    assert not remove_epoch(ws, STRUCTURE, "e0")


def test_the_next_publication_finishes_the_one_before(ws: Workspace) -> None:
    with pytest.raises(Crash):
        publish_epoch(ws, STRUCTURE, "e0", new_tables(), after_step=crash_after(len(EPOCH_TABLES) + 3))
    publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1))
    assert [row.epoch for row in rows_of(ws, TiltRow)] == ["e0", "e1"]


def test_recovery_reports_what_it_did(ws: Workspace) -> None:
    assert recover(ws).outcome == "nothing to do"
    with pytest.raises(Crash):
        publish_epoch(ws, STRUCTURE, "e0", new_tables(), after_step=crash_after(2))
    assert recover(ws).temps_swept == 2
    with pytest.raises(Crash):
        publish_epoch(ws, STRUCTURE, "e0", new_tables(), after_step=crash_after(len(EPOCH_TABLES) + 3))
    found = recover(ws)
    assert (found.outcome, found.epoch) == ("finished", EpochKey(STRUCTURE, "e0"))


def test_temps_damaged_before_the_first_rename_leave_the_old_epoch(ws: Workspace) -> None:
    publish_old(ws)
    old = stored(ws)
    with pytest.raises(Crash):
        publish_epoch(ws, STRUCTURE, "e0", new_tables(), after_step=crash_after(len(EPOCH_TABLES) + 2))
    next(ws.tables.glob("tilt/*/*.tmp")).write_bytes(b"damaged")
    assert recover(ws).outcome == "dropped"
    assert stored(ws) == old


def test_temps_damaged_after_the_first_rename_never_show_a_mixed_epoch(ws: Workspace) -> None:
    publish_old(ws)
    with pytest.raises(Crash):
        publish_epoch(ws, STRUCTURE, "e0", new_tables(), after_step=crash_after(len(EPOCH_TABLES) + 3))
    next(ws.tables.glob("tilt/*/*.tmp")).write_bytes(b"damaged")
    assert recover(ws).outcome == "set aside"
    assert epochs_on_disk(ws) == []
    aside = list(ws.tmp.rglob("*.parquet"))
    assert len(aside) == len(EPOCH_TABLES)
    assert publish_epoch(ws, STRUCTURE, "e0", new_tables())


def test_a_damaged_journal_is_told(ws: Workspace) -> None:
    ws.journal.write_text("{")
    with pytest.raises(StorageError, match=r"publish-journal\.json is damaged"):
        recover(ws)


def test_equal_content_is_not_written_again(ws: Workspace) -> None:
    publish_epoch(ws, STRUCTURE, "e0", new_tables())
    before = {path: path.stat() for table in EPOCH_TABLES for path in files_of(ws, table)}
    assert not publish_epoch(ws, STRUCTURE, "e0", new_tables())
    after = {path: path.stat() for table in EPOCH_TABLES for path in files_of(ws, table)}
    assert {path: (s.st_ino, s.st_mtime_ns) for path, s in before.items()} == {
        path: (s.st_ino, s.st_mtime_ns) for path, s in after.items()
    }


def test_a_run_that_only_confirms_an_epoch_does_not_claim_it(ws: Workspace) -> None:
    publish_epoch(ws, STRUCTURE, "e0", epoch_tables("e0", run="run-1"))
    assert not publish_epoch(ws, STRUCTURE, "e0", epoch_tables("e0", run="run-2"))
    assert publish_epoch(ws, STRUCTURE, "e0", epoch_tables("e0", run="run-3", n_points_used=1))
    assert [row.run for row in rows_of(ws, TABLES["epochs"])] == ["run-3"]


def test_a_damaged_table_is_replaced_by_equal_content(ws: Workspace) -> None:
    publish_old(ws)
    table_path(ws, "epochs", STRUCTURE, "e0").write_bytes(b"PAR1")
    assert publish_epoch(ws, STRUCTURE, "e0", epoch_tables("e0", 0, OLD))
    assert rows_of(ws, TABLES["epochs"]) == epoch_tables("e0", 0, OLD)["epochs"]


def test_a_missing_table_is_refused(ws: Workspace) -> None:
    tables = epoch_tables("e0")
    del tables["slices"]
    with pytest.raises(StorageError, match=f"epoch {STRUCTURE}/e0 needs the tables .*slices.*; got epochs"):
        publish_epoch(ws, STRUCTURE, "e0", tables)


def test_two_rows_for_one_epoch_are_refused(ws: Workspace) -> None:
    tables = epoch_tables("e0")
    with pytest.raises(StorageError, match="needs one row in table epochs; got 2"):
        publish_epoch(ws, STRUCTURE, "e0", {**tables, "epochs": tables["epochs"] * 2})


def test_a_row_of_another_epoch_is_refused(ws: Workspace) -> None:
    tables = epoch_tables("e0")
    tables["tilt"].append(replace(tilt_row("e0"), epoch="e1"))
    with pytest.raises(
        StorageError, match=f"table tilt, row 1: needed epoch {STRUCTURE}/e0, got {STRUCTURE}/e1"
    ):
        publish_epoch(ws, STRUCTURE, "e0", tables)


def test_a_value_that_is_no_number_stops_the_whole_epoch(ws: Workspace) -> None:
    tables = epoch_tables("e0")
    tables["tilt"] = [tilt_row("e0", rmse_m=float("nan"))]
    with pytest.raises(StorageError, match="table tilt, column rmse_m, row 0"):
        publish_epoch(ws, STRUCTURE, "e0", tables)
    assert epochs_on_disk(ws) == []


@pytest.mark.parametrize("epoch", ["con", "../e0", "e0."])
def test_an_epoch_that_cannot_be_a_file_is_refused(ws: Workspace, epoch: str) -> None:
    with pytest.raises(InputError, match="of an epoch"):
        publish_epoch(ws, STRUCTURE, epoch, epoch_tables(epoch))


def test_ids_that_differ_in_capitals_only_are_refused(ws: Workspace) -> None:
    publish_old(ws)
    with pytest.raises(StorageError, match="id 'E0' differs from the stored 'e0' in capitals only"):
        publish_epoch(ws, STRUCTURE, "E0", epoch_tables("E0"))


def test_rows_can_be_read_of_one_epoch(ws: Workspace) -> None:
    publish_old(ws)
    publish_epoch(ws, STRUCTURE, "e1", epoch_tables("e1", 1))
    assert {row.epoch for row in rows_of(ws, SliceRow, STRUCTURE, "e1")} == {"e1"}
    assert rows_of(ws, ChangeTestRow) == []


def test_only_temps_that_nobody_can_still_write_are_swept(ws: Workspace) -> None:
    young, old = ws.artifacts / "incoming.1.tmp", ws.artifacts / "incoming.2.tmp"
    young.touch()
    old.touch()
    os.utime(old, (0, 0))
    assert recover(ws).temps_swept == 1
    assert young.exists()


def test_dot_files_of_a_crash_are_not_seen_as_tables(ws: Workspace) -> None:
    publish_old(ws)
    (Path(table_path(ws, "tilt", STRUCTURE, "e9")).with_suffix(".parquet.1.tmp")).write_bytes(b"half")
    assert len(files_of(ws, "tilt")) == 1


@pytest.mark.parametrize(
    "place",
    [
        "{folder}/x.tmp",
        "../x.tmp",
        "tables/../../x.tmp",
        "tables/x.tmp",
        "runs/a/x.tmp",
        "tables/a\\b/x.tmp",
        "tables/a/C:x.tmp",
    ],
)
@pytest.mark.parametrize("what", ["removal", "target", "temp"])
def test_a_journal_that_leads_out_of_the_tables_is_refused_and_touches_nothing(
    ws: Workspace, tmp_path: Path, what: str, place: str
) -> None:
    """A workspace may come from others: its journal must not rename or remove what is not a publication's."""
    fill(ws, 1)
    victim = tmp_path / "x.tmp"
    victim.write_bytes(b"precious")
    place = place.format(folder=tmp_path)
    sha256 = hashlib.sha256(b"precious").hexdigest()
    rename = {"temp": "tables/tilt/a/x.tmp", "target": "tables/tilt/a/x.parquet", "sha256": sha256}
    renames = [] if what == "removal" else [{**rename, what: place}]
    removals = [place] if what == "removal" else []
    told = {"structure": STRUCTURE, "epoch": "e0", "renames": renames, "removals": removals}
    ws.journal.write_text(json.dumps(told))
    before = {path: path.read_bytes() for path in ws.tables.rglob("*.parquet")}
    with pytest.raises(StorageError, match=r"publish-journal\.json is damaged"):
        recover(ws)
    assert victim.read_bytes() == b"precious"
    assert {path: path.read_bytes() for path in ws.tables.rglob("*.parquet")} == before
