"""Runs that are interrupted, that meet a fault of the program, or that run at the same time."""

import json
import os
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from flows.ledger import StageEvent
from flows.run_campaign import RunRequest, run_campaign
from storage.errors import ShapeError
from storage.records import StageRunRow
from storage.tables import EPOCH_TABLES
from storage.verify import verify_workspace
from storage.workspace import Workspace
from tasks.preprocessing import isolate_scans
from tests.faults.sites import FIRST, SECOND, Site, state_of
from tests.flows.calls import ROOT
from tests.flows.campaigns import STRUCTURE, rows

TABLES_OF_EPOCH = sorted(EPOCH_TABLES)


def files_of(site: Site, epoch: str) -> list[Path]:
    return sorted((site.workspace / "tables").glob(f"*/{STRUCTURE}/{epoch}.parquet"))


def assert_whole(site: Site) -> None:
    report = verify_workspace(Workspace(site.workspace))
    assert not report.faults, report.faults


def break_second(monkeypatch: pytest.MonkeyPatch, site: Site, fault: Exception) -> None:
    """Let the isolation of the shaft fail for the second epoch, and make it necessary."""
    text = site.text().replace("[limits]", "[preprocessing]\nvoxel_m = 0.006\n\n[limits]")
    site.file.write_text(text, encoding="utf-8")
    calls = []

    def isolate(scans: object, *rest: object) -> object:
        calls.append(scans)
        if len(calls) == 2:
            raise fault
        return isolate_scans(scans, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr("tasks.epoch_shaft.isolate_scans", isolate)


@pytest.mark.parametrize("stage", ["registration", "evaluation"])
def test_an_interrupted_run_leaves_a_whole_catalog_and_the_next_one_finishes(
    unpublished: Site, stage: str
) -> None:
    def interrupt(event: StageEvent) -> None:
        if (event.epoch, event.stage) == (SECOND, stage):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_campaign(RunRequest(unpublished.file, unpublished.workspace, schemes=("A",)), interrupt)
    assert unpublished.states() == {FIRST: "ok"}
    assert files_of(unpublished, SECOND) == []
    assert_whole(unpublished)
    assert unpublished.run("--epoch", SECOND, "--scheme", "A").code == 0
    assert unpublished.states() == {FIRST: "ok", SECOND: "ok"}


def test_an_interrupt_at_the_command_line_ends_with_exit_code_130(
    unpublished: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(_event: StageEvent) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("flows.progress.print_stage", interrupt)
    told = unpublished.run()
    assert (told.code, told.out) == (130, "")
    assert "error: interrupted; what was finished is kept\n" in told.err


@pytest.mark.parametrize(
    "fault",
    [
        RuntimeError("the sky fell"),
        pytest.param(ShapeError("needs points (n, 3), got (3, n)"), marks=pytest.mark.slow),
    ],
    ids=["library", "own"],
)
def test_a_fault_of_the_program_stops_its_epoch_alone_and_leaves_a_log(
    unpublished: Site, monkeypatch: pytest.MonkeyPatch, fault: Exception
) -> None:
    break_second(monkeypatch, unpublished, fault)
    third = unpublished.text()[unpublished.text().rindex("[[epochs]]") :]
    third = third.replace(f'id = "{SECOND}"', 'id = "third"').replace("2025-04-14", "2025-07-14")
    (unpublished.folder / "third").mkdir()
    for scan in (unpublished.folder / SECOND).glob("*.laz"):
        shutil.copy(scan, unpublished.folder / "third" / scan.name)
    unpublished.append(third.replace(f'"{SECOND}/', '"third/'))
    told = unpublished.run("--scheme", "A", "--json")
    assert (told.code, told.answer["ok"]) == (1, False)
    assert state_of(told, SECOND)["state"] == "failed"
    assert unpublished.states() == {FIRST: "ok", "third": "ok"}
    assert files_of(unpublished, SECOND) == []
    assert [path.parent.parent.name for path in files_of(unpublished, "third")] == TABLES_OF_EPOCH
    assert_whole(unpublished)
    what = f"{type(fault).__name__}: {fault}"
    assert f"error: {SECOND}: fault of the program: {what}\n" in told.err
    (log,) = (unpublished.workspace / "logs").glob("tiltwatch-*.log")
    assert f"error: {SECOND}: traceback in {log}\n" in told.err
    assert "Traceback" in log.read_text("utf-8") and what in log.read_text("utf-8")
    failed = "select epoch, stage, reason from runs where run = ? and outcome = 'failed'"
    assert unpublished.query(failed, (told.answer["run"],)) == [(SECOND, "preprocessing", what)]


@pytest.mark.slow
def test_the_run_after_a_fault_of_the_program_finishes(
    unpublished: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as broken:
        break_second(broken, unpublished, RuntimeError("the sky fell"))
        assert unpublished.run("--scheme", "A").code == 1
    assert unpublished.run("--scheme", "A").code == 0
    assert unpublished.states() == {FIRST: "ok", SECOND: "ok"}


@pytest.mark.slow
def test_a_drive_that_was_away_for_a_moment_is_not_remembered(
    unpublished: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = unpublished.scan("ST02")
    content = bytearray(scan.read_bytes())
    content[30] ^= 0xFF  # the name of the writing system: the file is new to the cache, its points are not
    scan.write_bytes(content)
    os.utime(scan, (0.0, 0.0))
    opened, open_file = [], Path.open

    def open_once(path: Path, *rest: object, **named: object) -> object:
        if path == scan:
            opened.append(path)
            if len(opened) > 1:
                raise OSError(5, "Input/output error")
        return open_file(path, *rest, **named)  # type: ignore[call-overload]

    with monkeypatch.context() as broken:
        broken.setattr(Path, "open", open_once)
        told = unpublished.run("--epoch", SECOND, "--scheme", "A", "--json")
    assert (told.code, state_of(told, SECOND)["state"]) == (3, "degraded")
    assert f"station ST02: {scan}: needs a readable file, came Input/output error" in told.err
    again = unpublished.run("--epoch", SECOND, "--scheme", "A", "--json")
    assert (again.code, state_of(again, SECOND)["state"]) == (0, "ok")


@pytest.mark.slow
def test_two_runs_at_once_both_end_well_and_compute_and_publish_everything_once(
    unpublished: Site, tmp_path: Path
) -> None:
    replaced = unpublished.text().replace("[limits]", "[preprocessing]\nvoxel_m = 0.006\n\n[limits]")
    unpublished.file.write_text(replaced, encoding="utf-8")
    command = [sys.executable, "-m", "flows.cli", "run", str(unpublished.file), "--scheme", "A", "--json"]
    command += ["--workspace", str(unpublished.workspace)]
    # code of its own: an edit of the working tree between their starts would rightly compute everything twice
    checkout = tmp_path / "checkout"
    for package in ("flows", "tasks", "storage"):
        shutil.copytree(ROOT / package, checkout / package, ignore=shutil.ignore_patterns("__pycache__"))
    both = [
        subprocess.Popen(command, cwd=checkout, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    told = [process.communicate(timeout=200) for process in both]
    assert [process.returncode for process in both] == [0, 0], told
    answers = [json.loads(out) for out, _ in told]
    assert unpublished.states() == {FIRST: "ok", SECOND: "ok"}
    assert_whole(unpublished)
    runs = [rows(unpublished.workspace, "runs", answer["run"]) for answer in answers]
    computed = Counter((row.epoch, row.stage) for run in runs for row in run if row.state == "computed")
    assert computed
    assert [stage for stage, times in computed.items() if times > 1] == []
    for epoch in (FIRST, SECOND):
        spans = sorted(_span(row for row in run if row.epoch == epoch) for run in runs)
        assert spans[0][1] <= spans[1][0], f"both runs were in {epoch} at once"


def _span(rows: Iterable[StageRunRow]) -> tuple[datetime, datetime]:
    """From when the first stage was asked for to when the last one had ended, as far as the ledger knows."""
    known = [(row.started_at, row.started_at + timedelta(seconds=row.seconds or 0.0)) for row in rows]
    return min(start for start, _end in known), max(end for _start, end in known)
