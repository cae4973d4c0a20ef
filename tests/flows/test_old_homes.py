"""Homes of workflow servers that nobody uses any more go; those in use, and one's own, stay."""

import os
import time
from pathlib import Path

import pytest

from flows.old_homes import UNUSED_S, sweep_old_homes
from flows.workflow_server import server_lock


def home(folder: Path, name: str, *, age_s: float) -> Path:
    made = folder / name
    made.mkdir(parents=True)
    (made / "prefect.db").write_text("flow runs")
    for path in (made / "prefect.db", made):
        os.utime(path, times=(time.time() - age_s,) * 2)
    return made


def test_only_homes_that_nobody_used_for_long_go(tmp_path: Path) -> None:
    own, old, young = (
        home(tmp_path, name, age_s=age_s)
        for name, age_s in (("own", 2 * UNUSED_S), ("old", 2 * UNUSED_S), ("young", 0.5 * UNUSED_S))
    )
    (tmp_path / "prefect.db").write_text("of an earlier version")
    sweep_old_homes(tmp_path, own)
    assert (own.is_dir(), old.exists(), young.is_dir()) == (True, False, True)
    assert (tmp_path / "prefect.db").is_file()


def test_a_home_whose_database_changed_just_now_is_in_use(tmp_path: Path) -> None:
    old = home(tmp_path, "old", age_s=2 * UNUSED_S)
    os.utime(old / "prefect.db")
    sweep_old_homes(tmp_path, tmp_path / "own")
    assert old.is_dir()


def test_a_home_that_somebody_holds_stays(tmp_path: Path) -> None:
    old = home(tmp_path, "old", age_s=2 * UNUSED_S)
    with server_lock(old):
        for path in (*old.iterdir(), old):
            os.utime(path, times=(time.time() - 2 * UNUSED_S,) * 2)
        sweep_old_homes(tmp_path, tmp_path / "own")
    assert old.is_dir()


def test_no_folder_is_no_fault(tmp_path: Path) -> None:
    sweep_old_homes(tmp_path / "none", tmp_path / "none" / "own")
    assert not (tmp_path / "none").exists()


def test_a_home_that_another_process_removes_meanwhile_is_no_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = home(tmp_path, "old", age_s=2 * UNUSED_S)
    monkeypatch.setattr("flows.old_homes._last_used_s", lambda _home: Path(tmp_path / "gone").stat().st_mtime)
    sweep_old_homes(tmp_path, tmp_path / "own")
    assert old.is_dir()
