"""The record of a run says whether its process lives, and keeps what it did when it does not."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from storage.run_record import (
    held_record,
    journal_of,
    may_live,
    read_record,
    record_of_this_process,
    remove_record,
    runs_on_record,
    taken_from_dead,
)
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE

ROOT = Path(__file__).resolve().parents[2]


def test_a_run_under_way_is_not_taken_for_dead(ws: Workspace) -> None:
    record = record_of_this_process("run-1", STRUCTURE, "own")
    with held_record(ws, record), taken_from_dead(ws, "run-1") as found:
        assert found is None
    assert may_live(record)


def test_a_process_that_this_user_may_not_look_at_is_not_taken_for_dead(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    record = record_of_this_process("run-1", STRUCTURE, "own")

    def hidden(pid: int) -> psutil.Process:
        raise psutil.AccessDenied(pid)

    monkeypatch.setattr(psutil, "Process", hidden)
    assert may_live(record)


def test_a_run_whose_process_was_killed_is_taken_by_one_alone_with_all_that_it_did(ws: Workspace) -> None:
    code = (
        "import os, signal, sys; from pathlib import Path; from storage.workspace import Workspace\n"
        "from storage.run_record import held_record, record_of_this_process\n"
        f"ws = Workspace(Path({str(ws.root)!r}))\n"
        f"with held_record(ws, record_of_this_process('run-1', {STRUCTURE!r}, 'own')) as journal:\n"
        "    journal.append({'asked': 1}); journal.append({'row': 2})\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False, timeout=60)
    assert runs_on_record(ws) == ["run-1"]
    with taken_from_dead(ws, "run-1") as found, taken_from_dead(ws, "run-1") as second:
        assert found is not None
        assert (found.structure, found.ended_at) == (STRUCTURE, None)
        assert second is None
        assert not may_live(found)
    assert journal_of(ws, "run-1").lines()[0] == [{"asked": 1}, {"row": 2}]
    remove_record(ws, "run-1")
    assert runs_on_record(ws) == []


def test_a_process_id_that_is_used_again_is_another_process(ws: Workspace) -> None:
    record = record_of_this_process("run-1", STRUCTURE, "own")
    assert not may_live(replace(record, process_started_at=record.process_started_at - 3600.0))
    assert may_live(replace(record, host="another", pid=1))


def test_a_run_that_an_earlier_version_began_may_still_live(ws: Workspace) -> None:
    record = record_of_this_process("run-1", STRUCTURE, "own")
    began = psutil.Process().create_time()
    assert may_live(replace(record, boot=None, process_started_at=began))
    assert not may_live(replace(record, boot=None, process_started_at=began - 3600.0))
    assert not may_live(replace(record, boot="another"))


@pytest.mark.parametrize("torn", [b'{"row": 1', b'{"row": 1}garbage', b"\xff\xfe", b"[1]"])
def test_a_line_torn_by_a_kill_costs_that_line_alone(ws: Workspace, torn: bytes) -> None:
    with held_record(ws, record_of_this_process("run-1", STRUCTURE, "own")) as journal:
        journal.append({"first": 1})
        journal.path.write_bytes(journal.path.read_bytes() + torn)
        assert journal.lines()[0] == [{"first": 1}]
        journal.append({"second": 2})
        assert journal.lines()[0] == [{"first": 1}, {"second": 2}]


def test_a_journal_is_read_on_from_where_it_was_left(ws: Workspace) -> None:
    with held_record(ws, record_of_this_process("run-1", STRUCTURE, "own")) as journal:
        journal.append({"first": 1})
        _lines, here = journal.lines()
        journal.append({"second": 2})
        assert journal.lines(here)[0] == [{"second": 2}]


def test_a_torn_record_is_none(ws: Workspace) -> None:
    with held_record(ws, record_of_this_process("run-1", STRUCTURE, "own")) as journal:
        journal.path.with_suffix(".json").write_text("{", encoding="utf-8")
        assert read_record(ws, "run-1") is None
