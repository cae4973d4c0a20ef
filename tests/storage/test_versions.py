"""Earlier results are kept under their version: nothing that was published is ever lost."""

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from storage.archive import archive_version
from storage.catalog import rebuild_catalog
from storage.digests import file_sha256, text_sha256
from storage.errors import InputError
from storage.ledger import store_settings
from storage.mend import losses, mend_copies
from storage.parquet import read_rows
from storage.publish import publish_epoch, recover
from storage.records import EpochRow, TiltRow
from storage.tables import EPOCH_TABLES, EpochKey, table_path
from storage.verify import verify_workspace
from storage.version import VersionChangeRow
from storage.versions import archive_fault, put_aside, unfinished_archives, version_folder
from storage.views import tilt_rows, version_change_rows, version_rows, version_tilt_rows
from storage.workspace import Workspace
from tests.faults.damages import DAMAGES
from tests.storage.campaign import STRUCTURE, epoch_tables, fill, tilt_row

OLD, NEW = (0.007, -0.0057), (0.0071, -0.0057)
KEY = EpochKey(STRUCTURE, "e0")
N_STEPS = len(EPOCH_TABLES) + 1

CRASH = """
import os, sys
from pathlib import Path
from storage.tables import EpochKey
from storage.versions import put_aside
from storage.workspace import Workspace
done = []
def step(name):
    done.append(name)
    if len(done) == int(sys.argv[2]):
        os._exit(9)
put_aside(Workspace(Path(sys.argv[1])), EpochKey("chimney-01", "e0"), "old", "test", after_step=step)
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


def publish(ws: Workspace, lean: tuple[float, float], run: str = "run-1", **tables: list[object]) -> bool:
    return publish_epoch(ws, STRUCTURE, "e0", {**epoch_tables("e0", 0, lean, run=run), **tables})


def names(ws: Workspace) -> list[str]:
    return sorted(path.parent.name for path in ws.versions.glob(f"{STRUCTURE}/*/e0"))


def archived_lean(ws: Workspace, version: str) -> float:
    path = version_folder(ws, STRUCTURE, version, "e0") / "tilt.parquet"
    return read_rows(path, "tilt", TiltRow)[0].lean_east


def change(ws: Workspace, version: str = "before-run-2") -> VersionChangeRow:
    rebuild_catalog(ws)
    (row,) = version_change_rows(ws, STRUCTURE, version)
    return row


def test_a_result_that_is_replaced_is_kept_under_the_run_that_replaces_it(ws: Workspace) -> None:
    publish(ws, OLD)
    before = {table: file_sha256(table_path(ws, table, STRUCTURE, "e0")) for table in EPOCH_TABLES}
    publish(ws, NEW, "run-2")
    folder = version_folder(ws, STRUCTURE, "before-run-2", "e0")
    assert {table: file_sha256(folder / f"{table}.parquet") for table in EPOCH_TABLES} == before
    assert archive_fault(folder) is None


def test_equal_rows_another_run_and_other_settings_archive_nothing(ws: Workspace) -> None:
    publish(ws, OLD)
    again = epoch_tables("e0", 0, OLD, run="run-2", campaign_digest="of other settings")
    assert not publish_epoch(ws, STRUCTURE, "e0", again)
    assert names(ws) == []


def test_a_scheme_more_archives_nothing_and_a_scheme_less_does(ws: Workspace) -> None:
    both: list[object] = [tilt_row("e0", 0, OLD), replace(tilt_row("e0", 0, OLD), scheme="B")]
    publish(ws, OLD)
    publish(ws, OLD, "run-2", tilt=both)
    assert names(ws) == []
    publish(ws, OLD, "run-3")
    assert names(ws) == ["before-run-3"]


def test_an_epoch_without_an_axis_leaves_nothing_to_keep(ws: Workspace) -> None:
    publish(ws, OLD, tilt=[])
    publish(ws, OLD, "run-2")
    assert names(ws) == []


def test_what_is_kept_already_is_not_kept_twice(ws: Workspace) -> None:
    publish(ws, OLD)
    archive_version(ws, STRUCTURE, "named", ["e0"], "test")
    publish(ws, NEW, "run-2")
    assert names(ws) == ["named"]


def test_results_that_come_and_go_are_all_kept(ws: Workspace) -> None:
    leans = [(0.001 * n, 0.0) for n in range(1, 5)]
    for lean in leans:
        publish(ws, lean, "run-2")
    kept = {archived_lean(ws, name) for name in names(ws)}
    assert kept == {lean[0] for lean in leans[:-1]}
    assert names(ws) == ["before-run-2", "before-run-2.2", "before-run-2.3"]


def test_a_damaged_table_is_left_out_and_the_others_are_kept(ws: Workspace) -> None:
    publish(ws, OLD)
    table_path(ws, "slices", STRUCTURE, "e0").write_bytes(b"PAR1")
    publish(ws, NEW, "run-2")
    folder = version_folder(ws, STRUCTURE, "before-run-2", "e0")
    assert {path.stem for path in folder.glob("*.parquet")} == set(EPOCH_TABLES) - {"slices"}
    assert archive_fault(folder) is None


def test_without_hard_links_files_are_copied(ws: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_args: object) -> None:
        raise OSError

    monkeypatch.setattr(os, "link", refuse)
    publish(ws, OLD)
    publish(ws, NEW, "run-2")
    assert archived_lean(ws, "before-run-2") == OLD[0]


@pytest.mark.parametrize("count", [1, len(EPOCH_TABLES) // 2, N_STEPS])
def test_after_a_crash_the_version_has_the_epoch_whole_or_not_at_all(ws: Workspace, count: int) -> None:
    publish(ws, OLD)
    with pytest.raises(Crash):
        put_aside(ws, KEY, "old", "test", after_step=crash_after(count))
    assert names(ws) == []
    assert archive_version(ws, STRUCTURE, "old", ["e0"], "test") == ["e0"]
    assert archive_fault(version_folder(ws, STRUCTURE, "old", "e0")) is None


def test_a_process_that_dies_while_it_keeps_an_epoch_leaves_nothing_behind(ws: Workspace) -> None:
    publish(ws, OLD)
    died = subprocess.run([sys.executable, "-c", CRASH, str(ws.root), "3"], check=False)
    assert died.returncode == 9
    assert len(unfinished_archives(ws)) == 1
    assert [fault.what for fault in verify_workspace(ws).faults if "versions" in fault.where] == [
        "unfinished file that nobody writes any more"
    ]
    rebuild_catalog(ws)
    assert version_rows(ws, STRUCTURE) == []
    recover(ws)
    assert unfinished_archives(ws) == []
    assert tilt_rows(ws, STRUCTURE)[0].lean_east == OLD[0]


def test_a_crash_between_keeping_and_publishing_keeps_once(ws: Workspace) -> None:
    publish(ws, OLD)
    with pytest.raises(Crash):
        publish_epoch(ws, STRUCTURE, "e0", epoch_tables("e0", 0, NEW, run="run-2"), after_step=crash_after(1))
    assert names(ws) == ["before-run-2"]
    publish(ws, NEW, "run-3")
    assert names(ws) == ["before-run-2"]
    assert archived_lean(ws, "before-run-2") == OLD[0]


def test_a_version_goes_on_with_the_epochs_that_it_lacks(ws: Workspace) -> None:
    fill(ws, 3)
    assert archive_version(ws, STRUCTURE, "old", ["e0", "e2"], "test") == ["e0", "e2"]
    publish(ws, NEW, "run-2")
    assert archive_version(ws, STRUCTURE, "old", ["e0", "e1", "e2", "e9"], "test") == ["e1"]
    assert archived_lean(ws, "old") == OLD[0]


def test_a_name_that_cannot_be_a_folder_is_refused(ws: Workspace) -> None:
    with pytest.raises(InputError, match=r"'\.\./x' of a version cannot be a file name"):
        archive_version(ws, STRUCTURE, "../x", ["e0"], "test")


def test_the_catalog_shows_versions_with_what_made_them(ws: Workspace) -> None:
    fill(ws, 2)
    publish(ws, NEW, "run-2")
    rebuild_catalog(ws)
    (row,) = version_rows(ws, STRUCTURE)
    assert (row.version, row.epoch, row.run, row.state) == ("before-run-2", "e0", "run-1", "ok")
    assert (row.code_version, row.why) == ("c0de", "replaced by run run-2")
    (axis,) = version_tilt_rows(ws, STRUCTURE, "before-run-2")
    assert (axis.version, axis.lean_east) == ("before-run-2", OLD[0])
    assert {row.lean_east for row in tilt_rows(ws, STRUCTURE, "e0")} == {NEW[0]}


def test_changes_are_stated_in_metres_and_in_sigmas_of_then(ws: Workspace) -> None:
    publish(ws, OLD, tilt=[tilt_row("e0", 0, OLD, lean_cov_en=0.0, verdict="pass")])
    wider = tilt_row("e0", 0, NEW, lean_cov_ee=16e-10, lean_cov_en=0.0, lean_cov_nn=36e-10, verdict="fail")
    publish(ws, NEW, "run-2", tilt=[wider])
    row = change(ws)
    assert row.outcome == "changed"
    assert row.d_top_m == pytest.approx(102.0 * 1e-4)
    # the lean moved by 1e-4 to the east, where sigma was 2e-5
    assert row.d_sigmas == pytest.approx(5.0)
    assert row.sigma_ratio == pytest.approx(2.0)
    assert (row.verdict_before, row.verdict_now, row.verdict_changed) == ("pass", "fail", True)


def test_an_axis_that_is_the_same_is_unchanged_and_one_that_lacks_is_gone(ws: Workspace) -> None:
    publish(ws, OLD)
    archive_version(ws, STRUCTURE, "same", ["e0"], "test")
    assert change(ws, "same").outcome == "unchanged"
    publish(ws, OLD, "run-2", tilt=[replace(tilt_row("e0", 0, OLD), scheme="B")])
    row = change(ws, "same")
    assert (row.outcome, row.d_top_m, row.verdict_changed) == ("gone", None, None)


def test_an_axis_without_a_covariance_has_no_sigmas(ws: Workspace) -> None:
    unknown = {"lean_cov_ee": None, "lean_cov_en": None, "lean_cov_nn": None}
    publish(ws, OLD, tilt=[tilt_row("e0", 0, OLD, **unknown)])
    publish(ws, NEW, "run-2")
    row = change(ws)
    assert (row.outcome, row.d_sigmas, row.sigma_ratio) == ("changed", None, None)
    assert row.d_top_m is not None


def test_verification_finds_a_flipped_byte_of_a_version(ws: Workspace) -> None:
    fill(ws, 1)
    publish(ws, NEW, "run-2")
    rebuild_catalog(ws)
    assert verify_workspace(ws).faults == ()
    path = version_folder(ws, STRUCTURE, "before-run-2", "e0") / "slices.parquet"
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    (fault,) = verify_workspace(ws).faults
    assert fault.where == f"versions/{STRUCTURE}/before-run-2/e0"
    assert "slices does not have the digest" in fault.what


@pytest.mark.parametrize("damage", ["flipped", "truncated", "emptied", "deleted", "folder"])
def test_a_run_says_which_earlier_results_are_damaged_until_they_are_moved_away(
    ws: Workspace, tmp_path: Path, damage: str
) -> None:
    publish(ws, OLD)
    publish(ws, NEW, "run-2")
    assert losses(ws) == []
    folder = version_folder(ws, STRUCTURE, "before-run-2", "e0")
    DAMAGES[damage](folder / "slices.parquet", None)
    (told,) = losses(ws)
    assert (told.where, told.is_lost) == (f"versions/{STRUCTURE}/before-run-2/e0", True)
    assert "table slices" in told.what
    assert "move the folder out" in told.what
    folder.rename(tmp_path / "elsewhere")
    mend_copies(ws)
    assert losses(ws) == []


@pytest.mark.parametrize("file", ["tilt.parquet", "manifest.json"])
def test_a_damaged_version_does_not_keep_the_present_from_being_shown(ws: Workspace, file: str) -> None:
    publish(ws, OLD)
    publish(ws, NEW, "run-2")
    (version_folder(ws, STRUCTURE, "before-run-2", "e0") / file).write_bytes(b"{")
    rebuild_catalog(ws)
    assert [row.lean_east for row in tilt_rows(ws, STRUCTURE)] == [NEW[0]]
    assert any("before-run-2" in fault.where for fault in verify_workspace(ws).faults)


def test_a_workspace_with_versions_keeps_them_when_it_is_moved(ws: Workspace, tmp_path: Path) -> None:
    publish(ws, OLD)
    publish(ws, NEW, "run-2")
    moved = Workspace(ws.root.rename(tmp_path / "moved"))
    rebuild_catalog(moved)
    assert [row.version for row in version_rows(moved, STRUCTURE)] == ["before-run-2"]


def test_equal_rows_in_another_frame_are_published_under_its_settings(ws: Workspace) -> None:
    digests = []
    for code in (32650, 32651):
        text = f'{{"frame": {{"horizontal": "EPSG:{code}"}}}}'
        digests.append(text_sha256(text))
        store_settings(ws, digests[-1], text)
    first, second = (epoch_tables("e0", 0, OLD, run="run-1", campaign_digest=digest) for digest in digests)
    assert publish_epoch(ws, STRUCTURE, "e0", first)
    assert publish_epoch(ws, STRUCTURE, "e0", second)
    assert not publish_epoch(ws, STRUCTURE, "e0", second)
    (row,) = read_rows(table_path(ws, "epochs", STRUCTURE, "e0"), "epochs", EpochRow)
    assert row.campaign_digest == digests[1]
