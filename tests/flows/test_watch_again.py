"""A run that a full drive ended is tried again by the watch; one that bad input ended is not."""

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import pytest

from flows.child_process import ChildOutcome
from flows.outcome import failed_epoch
from flows.run_report import answer_of
from flows.watch import runs
from flows.watch.events import Teller
from flows.watch.place import WatchPlace
from storage.errors import InputError, StorageError
from storage.intake import read_run_note, write_intake
from storage.workspace import open_workspace
from tasks.settings.intake import Intake, intake_text

NOW = datetime(2026, 3, 11, 6, 0, tzinfo=UTC)
INTAKE = Intake(epoch="e1", time=NOW, first_arrival=NOW, complete="marker")


def answer(fault: Exception | None) -> str:
    """What a run writes whose only epoch ended by a fault; nothing came of the run itself for None."""
    if fault is None:
        return json.dumps({"ok": False, "errors": ["no space left on device"]})
    outcome = SimpleNamespace(
        workspace=Path(), run="r1", computed=0, cached=0, epochs=(failed_epoch("e1", fault),)
    )
    return json.dumps(answer_of(outcome, []))  # type: ignore[arg-type]


class Tried:
    """Runs of a watch that all end at once, and in the same way."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, stdout: str) -> None:
        self.ws = open_workspace(folder / "ws")
        self.count = 0
        self.outcome = ChildOutcome(3, timed_out=False, seconds=1.0, stdout=stdout, stderr_tail="")

        @contextmanager
        def started(*_what: object, **_how: object) -> Iterator[SimpleNamespace]:
            self.count += 1
            yield SimpleNamespace(running=False, began_s=time.monotonic(), outcome=lambda: self.outcome)

        monkeypatch.setattr(runs, "started_child", started)
        write_intake(self.ws, "silo", "e1", intake_text(INTAKE))
        self.begin()

    def begin(self) -> None:
        """Start the watch anew."""
        place = WatchPlace(Path("campaign.toml"), "silo", self.ws, Path("inbox"))
        teller = Teller(self.ws, "silo", as_json=True, now=lambda: NOW)
        self.runs = runs.Runs(place, teller, lambda: NOW, 60.0)

    def follow(self) -> int:
        """Let the watch go round three times; gives how many runs there were."""
        for _round in range(3):
            self.runs.follow([INTAKE])
        return self.count


@pytest.mark.parametrize("fault", [StorageError("cannot write x: no space left on device"), None])
def test_a_run_that_met_a_full_drive_is_tried_again_after_a_while(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: Exception | None
) -> None:
    tried = Tried(tmp_path, monkeypatch, answer(fault))
    assert tried.follow() == 1
    monkeypatch.setattr(runs, "AGAIN_AFTER_S", 0.0)
    tried.begin()
    assert tried.follow() >= 2, "a new watch tries at once"
    before = tried.count
    assert tried.follow() > before, "and an old one when the while is over"


def test_a_run_that_met_bad_input_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "AGAIN_AFTER_S", 0.0)
    tried = Tried(tmp_path, monkeypatch, answer(InputError("e1: no such file")))
    assert tried.follow() == 1
    tried.begin()
    assert tried.follow() == 1
    note = read_run_note(tried.ws, "silo", "e1")
    assert note is not None
    assert note["exit_code"] == 3


def test_a_note_that_cannot_be_written_ends_no_watch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_what: object) -> None:
        raise StorageError("cannot write the note: no space left on device")

    monkeypatch.setattr(runs, "write_run_note", refuse)
    tried = Tried(tmp_path, monkeypatch, answer(StorageError("full")))
    assert tried.follow() == 1
    assert "cannot write the note" in capsys.readouterr().out


def test_a_run_that_ended_otherwise_when_it_was_tried_again_is_not_tried_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs, "AGAIN_AFTER_S", 0.0)
    tried = Tried(tmp_path, monkeypatch, answer(StorageError("cannot write x: no space left on device")))
    tried.runs.follow([INTAKE])
    tried.runs.follow([INTAKE])
    before = tried.count
    tried.outcome = ChildOutcome(
        1, timed_out=False, seconds=1.0, stdout="", stderr_tail="a fault of tiltwatch"
    )
    tried.follow()
    assert tried.count <= before + 1
