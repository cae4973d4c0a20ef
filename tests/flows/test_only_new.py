"""Epochs that did not change are not looked at again, where that is asked for."""

import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import pytest

from flows import recorded_run
from flows import run_campaign as run_campaign_module
from flows.flow_run_states import server_in_use
from flows.outcome import RunOutcome
from flows.run_campaign import RunRequest, run_campaign
from storage.artifacts import artifact_path
from storage.parquet import read_rows
from storage.publish import remove_epoch
from storage.records import StageRunRow
from storage.run_record import read_record, record_of_this_process, runs_on_record, write_record
from storage.tables import table_path
from storage.workspace import Workspace
from tasks.produced import record_result
from tests.flows.calls import ROOT
from tests.flows.campaigns import STRUCTURE, ignore, only_epoch, replace_text, small_campaign, stage_rows

EPOCH = "2025-01"
OWN_LIMIT = """[[limits]]
name = "own"
version = 1
kind = "in-service"
document = "works rule 12"
edition = "2019"
source = "a copy in the project folder"
points_m = [[20.0, 0.1], [120.0, {metres}]]
"""


@dataclass(frozen=True)
class Place:
    """A campaign of one epoch and its workspace."""

    file: Path
    workspace: Path

    def run(self, *, only_new: bool = True, **more: object) -> RunOutcome:
        return run_campaign(RunRequest(self.file, self.workspace, only_new=only_new, **more), ignore)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Place:
    """A campaign that was run."""
    folder = tmp_path_factory.mktemp("only-new")
    place = Place(small_campaign(folder / "campaign", points=20_000), folder / "ws")
    assert only_epoch(place.run()).state == "ok"
    return place


@pytest.fixture
def place(finished: Place, tmp_path: Path) -> Place:
    """A copy of it, settled where it lies now."""
    shutil.copytree(finished.file.parent, tmp_path / "campaign")
    shutil.copytree(finished.workspace, tmp_path / "ws")
    copied = Place(tmp_path / "campaign" / "campaign.toml", tmp_path / "ws")
    copied.run()
    return copied


@pytest.fixture(autouse=True)
def _no_server_of_the_user(monkeypatch: pytest.MonkeyPatch) -> None:
    """The server that tests share counts as one's own here: one that the user named is told of every run."""
    monkeypatch.setattr("flows.run_campaign.users_server", lambda: None)


@pytest.mark.slow
def test_a_server_that_the_user_named_is_told_of_every_run(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr("flows.run_campaign.users_server", lambda: "http://10.0.0.5:4200/api")
    engine = run_campaign_module._with_engine

    def with_engine(*arguments):  # type: ignore[no-untyped-def]
        asked.append(arguments)
        return engine(*arguments)

    monkeypatch.setattr(run_campaign_module, "_with_engine", with_engine)
    place.run(only_new=False, schemes=("A",))
    assert len(asked) == 1


def test_a_fault_in_an_epoch_is_left_to_the_engine(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_work: object) -> None:
        raise KeyError("a fault of the program")

    monkeypatch.setattr("flows.epochs_on_record.measure_epoch", broken)
    assert {row.state for row in stage_rows(place.run(only_new=False))} == {"cached"}


def test_an_epoch_that_did_not_change_is_not_looked_at(place: Place) -> None:
    again = place.run()
    assert stage_rows(again) == []
    assert only_epoch(again).state == "ok"
    assert only_epoch(again).notes[0].startswith("unchanged since run ")
    assert stage_rows(place.run(only_new=False)) != []


def files_of_runs(place: Place) -> list[Path]:
    folders = (place.workspace / "tables" / "runs", place.workspace / "runs")
    return sorted(path for folder in folders for path in folder.rglob("*"))


def test_a_run_without_anything_to_process_does_all_else_without_the_engine(place: Place) -> None:
    words = ["-q", "run", str(place.file), "--workspace", str(place.workspace), "--only-new"]
    code = f"import sys; from flows.cli import main; print(main({words})); print('prefect' in sys.modules)"
    before = files_of_runs(place)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.splitlines()[-2:] == ["0", "False"], done.stderr
    # one that comes every hour for decades must leave nothing behind
    assert files_of_runs(place) == before


@pytest.mark.slow
def test_a_run_whose_stages_are_all_on_record_needs_no_engine_and_says_the_same(place: Place) -> None:
    place.run(only_new=False, schemes=("A",))
    with_engine = stage_rows(place.run(only_new=False, schemes=("A",), time_limit_s=300.0))
    words = ["-q", "run", str(place.file), "--workspace", str(place.workspace), "--scheme", "A"]
    code = f"import sys; from flows.cli import main; print(main({words})); print('prefect' in sys.modules)"
    own = {name: value for name, value in os.environ.items() if not name.startswith("PREFECT_")}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True, env=own
    )
    assert done.stdout.splitlines()[-2:] == ["0", "False"], done.stderr
    newest = max(table_path(Workspace(place.workspace), "runs", STRUCTURE, "x").parent.glob("*"))
    alone = read_rows(newest, "runs", StageRunRow)
    assert [_but_when(row) for row in alone] == [_but_when(row) for row in with_engine]
    assert {row.state for row in alone} == {"cached"}
    assert newest.stem not in runs_on_record(Workspace(place.workspace))


def _but_when(row: StageRunRow) -> StageRunRow:
    return replace(row, run="", started_at=datetime(2026, 1, 1, tzinfo=UTC))


def test_epochs_on_record_go_first_and_the_engine_does_the_others(place: Place) -> None:
    text = place.file.read_text(encoding="utf-8")
    second = text[text.index("[[epochs]]") :].replace(f'id = "{EPOCH}"', 'id = "later"')
    second = second.replace("time = 2025-01-14", "time = 2025-02-14").replace("reference = true\n", "")
    shutil.copytree(place.file.parent / EPOCH, place.file.parent / "later")
    place.file.write_text(text + "\n" + second.replace(f'"{EPOCH}/', '"later/'), encoding="utf-8")
    both = place.run(only_new=False)
    states = {(row.epoch, row.state) for row in stage_rows(both)}
    assert states == {(EPOCH, "cached"), ("later", "cached"), ("later", "computed")}
    assert [epoch.epoch for epoch in both.epochs] == [EPOCH, "later"]
    # the same scans: said of the later epoch, as ever
    assert not [note for note in both.epochs[0].notes if "is it the right file" in note]
    assert [note for note in both.epochs[1].notes if f"of epoch {EPOCH}; is it the right file" in note]


def test_a_damaged_artifact_is_made_anew_by_a_run_that_would_need_no_engine(place: Place) -> None:
    record = next(Workspace(place.workspace).records.glob("evaluation-*"))
    produced = record_result(record.read_bytes())
    artifact_path(Workspace(place.workspace), produced.artifacts["tilt"]).unlink()
    computed = [row.stage for row in stage_rows(place.run(only_new=False)) if row.state == "computed"]
    assert computed == ["evaluation"]


def test_a_run_after_one_that_was_killed_settles_it(place: Place) -> None:
    # of the server that this process asks, whichever tests ran before; of another one it would wait for a run there
    record = record_of_this_process("20250101T000000Z-aaaaaa", STRUCTURE, server_in_use())
    workspace = Workspace(place.workspace)
    write_record(workspace, replace(record, pid=2**22 + 1))
    assert stage_rows(place.run()) == []
    assert read_record(workspace, record.run) is None


def test_a_scan_that_was_touched_is_looked_at(place: Place) -> None:
    scan = next(place.file.parent.glob(f"{EPOCH}/*.laz"))
    os.utime(scan, (time.time() - 100.0, time.time() - 100.0))
    assert stage_rows(place.run()) != []


def test_a_setting_that_matters_is_looked_at_and_an_alarm_is_not(place: Place) -> None:
    with place.file.open("a", encoding="utf-8") as file:
        file.write('\n[[alarms]]\nid = "late"\nwhen = "missed-campaign"\ninterval_days = 100\n')
    assert stage_rows(place.run()) == []
    replace_text(place.file, "height_m = 102.0", "height_m = 101.0")
    assert stage_rows(place.run()) != []


def test_an_epoch_whose_tables_are_gone_is_published_again(place: Place) -> None:
    assert remove_epoch(Workspace(place.workspace), STRUCTURE, EPOCH)
    assert stage_rows(place.run()) != []
    assert stage_rows(place.run()) == []


def test_a_scan_that_is_replaced_while_it_is_processed_is_looked_at_again(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = next(place.file.parent.glob(f"{EPOCH}/*.laz"))
    process = recorded_run.process_recorded

    def replaced_meanwhile(*arguments):  # type: ignore[no-untyped-def]
        done = process(*arguments)
        assert done
        copy = scan.with_suffix(".copy")
        shutil.copy2(scan, copy)
        copy.replace(scan)
        return done

    monkeypatch.setattr(recorded_run, "process_recorded", replaced_meanwhile)
    place.run(only_new=False)
    monkeypatch.undo()
    assert stage_rows(place.run()) != []


@pytest.mark.slow
def test_a_limit_of_an_own_file_is_looked_at(place: Place) -> None:
    own = place.file.parent / "own.toml"
    own.write_text(OWN_LIMIT.format(metres=0.5), encoding="utf-8")
    replace_text(place.file, 'table = "gb50078-concrete-quoted"', 'file = "own.toml"')
    place.run()
    assert stage_rows(place.run()) == []
    own.write_text(OWN_LIMIT.format(metres=0.6), encoding="utf-8")
    assert stage_rows(place.run()) != []
