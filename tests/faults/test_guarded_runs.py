"""Epochs that hang or crash in native code, and runs that are killed: the others go on, and nothing stays running."""

import json
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pytest
from prefect.client.orchestration import get_client

from storage.run_record import runs_on_record
from storage.verify import verify_workspace
from storage.workspace import Workspace
from tests.faults.sites import FIRST, SECOND, Site, state_of
from tests.flows.calls import ROOT

HANG = "ctypes.PyDLL(None).sleep(600)"
"""Sleeps in C and holds Python's lock: no thread of this process can do anything about it."""
CRASH = "os.kill(os.getpid(), signal.SIGSEGV)"

# read by every Python that starts with its folder on PYTHONPATH
SPOILT = """\
import ctypes, os, signal, sys
if any(word in sys.orig_argv for word in {programs!r}):
    from flows.ledger import RunLedger
    asked_before = RunLedger.asked
    def asked(ledger, asked):
        asked_before(ledger, asked)
        if (asked.epoch, asked.stage) == ({epoch!r}, {stage!r}):
            {deed}
    RunLedger.asked = asked
"""


@pytest.fixture
def spoil(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):  # type: ignore[no-untyped-def]
    """Let a stage of an epoch do something terrible in every process of the given modules."""

    def make(deed: str, *, epoch: str, stage: str = "registration", programs: Sequence[str]) -> None:
        folder = tmp_path / "spoilt"
        folder.mkdir()
        text = SPOILT.format(deed=deed, epoch=epoch, stage=stage, programs=tuple(programs))
        (folder / "sitecustomize.py").write_text(text, encoding="utf-8")
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(folder), str(ROOT)]))

    return make


def states_of_flow_runs(site: Site) -> Counter[str]:
    """States of the flow runs of a workspace, as the server knows them."""
    with get_client(sync_client=True) as client:
        found = client.read_flow_runs(limit=200)
    ours = [run for run in found if run.parameters.get("workspace") == str(site.workspace)]
    return Counter(str(run.state_type.value) for run in ours if run.state_type is not None)


def rows_of_run(site: Site, run: str) -> list[tuple]:  # type: ignore[type-arg]
    asked = "select epoch, stage, outcome, reason from runs where run = ? order by started_at"
    return site.query(asked, (run,))


def assert_first_fell_and_second_went_on(site: Site, told, reason: str) -> None:  # type: ignore[no-untyped-def]
    assert told.code == 1
    assert state_of(told, FIRST)["errors"] == [reason]
    assert state_of(told, SECOND)["state"] == "ok"
    assert site.states() == {SECOND: "ok"}
    failed = [row for row in rows_of_run(site, told.answer["run"]) if row[2] != "ok"]
    assert failed == [(FIRST, "registration", "failed", reason)]
    assert states_of_flow_runs(site)["RUNNING"] == 0


def test_an_epoch_that_crashes_in_native_code_is_told_and_the_others_go_on(unpublished: Site, spoil) -> None:  # type: ignore[no-untyped-def]
    spoil(CRASH, epoch=FIRST, programs=["flows.epochs_child"])
    told = unpublished.run("--scheme", "A", "--time-limit-s", "200", "--json")
    reason = "its process was ended by signal 11 (SIGSEGV)"
    assert_first_fell_and_second_went_on(unpublished, told, reason)


@pytest.mark.slow
def test_an_epoch_that_hangs_in_native_code_ends_at_its_limit_and_the_others_go_on(
    unpublished: Site,
    spoil,  # type: ignore[no-untyped-def]
) -> None:
    spoil(HANG, epoch=FIRST, programs=["flows.epochs_child"])
    told = unpublished.run("--scheme", "A", "--time-limit-s", "60", "--json")
    assert_first_fell_and_second_went_on(unpublished, told, "stopped at its time limit of 60 s")


@pytest.mark.slow
def test_a_run_that_was_killed_is_settled_by_the_next_one(unpublished: Site, spoil) -> None:  # type: ignore[no-untyped-def]
    spoil(HANG, epoch=SECOND, programs=["flows.cli"])
    place = Workspace(unpublished.workspace)
    before = set(runs_on_record(place))
    words = ["run", str(unpublished.file), "--workspace", str(unpublished.workspace), "--scheme", "A"]
    process = subprocess.Popen(
        [sys.executable, "-m", "flows.cli", *words],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        run = _wait_until_asked(place, before, SECOND, "registration")
    finally:
        process.kill()
        process.wait(20)
    assert states_of_flow_runs(unpublished)["RUNNING"] == 2
    told = unpublished.run("--scheme", "A", "--json")
    assert told.code == 0
    assert unpublished.states() == {FIRST: "ok", SECOND: "ok"}
    rows = rows_of_run(unpublished, run)
    assert {row[0] for row in rows} == {FIRST, SECOND}
    (cut,) = [row for row in rows if row[2] != "ok"]
    assert cut[:3] == (SECOND, "registration", "failed")
    assert cut[3].startswith(f"the run was cut short: process {process.pid} on ")
    states = states_of_flow_runs(unpublished)
    assert (states["CRASHED"], states["RUNNING"]) == (2, 0)
    assert run not in runs_on_record(place)
    assert not verify_workspace(place).faults


def _wait_until_asked(place: Workspace, before: set[str], epoch: str, stage: str) -> str:
    """Wait until a new run asks for a stage; gives its id."""
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline:
        for run in set(runs_on_record(place)) - before:
            journal = place.runs / "active" / f"{run}.jsonl"
            text = journal.read_text(encoding="utf-8") if journal.exists() else ""
            for line in filter(None, text.splitlines()):
                asked = json.loads(line).get("asked", {})
                if (asked.get("epoch"), asked.get("stage")) == (epoch, stage):
                    return run
        time.sleep(0.1)
    raise AssertionError(f"{epoch} {stage} was not asked for in time")
