"""Kills the writing of a workspace at every step of storage: ``python -m tests.faults.killing.storage_steps FOLDER``.

Writer and next writer are children of a process that imported storage and opened nothing, so that thousands of steps are
quick. What a run writes is written here with storage alone; whole runs are in ``tests.faults.killing.moments``.
"""

import json
import os
import random
import shutil
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from storage.alarm_log import UNNUMBERED, append_alarm_events
from storage.artifacts import put_json
from storage.assessed import basis_of, put_down_assessed
from storage.catalog import rebuild_catalog
from storage.digests import text_sha256
from storage.ledger import append_run, is_in_ledger, store_settings
from storage.locks import publish_lock
from storage.places import store_of
from storage.publish import publish_epoch
from storage.run_record import (
    end_record,
    held_record,
    journal_of,
    record_of_this_process,
    remove_record,
    runs_on_record,
    taken_from_dead,
)
from storage.sealed import json_digest
from storage.series import publish_series
from storage.settled import settle, stamps_of
from storage.tables import ALARM_EVENTS, SERIES_TABLES, files_of
from storage.workspace import Workspace, open_workspace
from tests.faults.killing.file_steps import Steps
from tests.faults.killing.stored import RESULTS, Content, Rows, content_of, left_behind, shown_epochs
from tests.flows.calls import ROOT
from tests.storage.campaign import SETTINGS, STRUCTURE, alarm_event_row, epoch_tables, fill, stage_run_row

ALARMS: Final = ("2025-03", "2025-04")


def write_run(ws: Workspace, run: str) -> None:
    """Write all that a run writes: settle the dead, replace an epoch, add another, and what follows from them."""
    for dead in runs_on_record(ws):
        _settle_dead(ws, dead)
    with held_record(ws, record_of_this_process(run, STRUCTURE, "own")) as journal:
        journal.append({"stage": "slicing"})
        _keep_stage(ws)
        changed = SETTINGS.replace("chimney", "chimney ")
        store_settings(ws, text_sha256(changed), changed)
        for number, epoch in enumerate(("e0", "e2")):
            publish_epoch(ws, STRUCTURE, epoch, epoch_tables(epoch, 2 * number, (0.008, -0.0057), run=run))
            rebuild_catalog(ws)
        settle(ws, STRUCTURE, "e0", "inputs", stamps_of([]))
        publish_series(ws, STRUCTURE, {table: [] for table in SERIES_TABLES})
        put_down_assessed(ws, STRUCTURE, basis_of(ws, STRUCTURE, "inputs"))
        _raise_alarms(ws)
        append_run(ws, run, STRUCTURE, [stage_run_row(run, "e0")])
        end_record(ws, run, finished=True)
    rebuild_catalog(ws)
    remove_record(ws, run)


def _keep_stage(ws: Workspace) -> None:
    """Keep an artifact and the record of the stage that made it, as a workflow engine has them kept."""
    made = put_json(ws, "facts", {"seed": 8})
    produced = {"artifacts": {"facts": made.to_json()}, "facts": {}}
    record = {"result": {**produced, "digest": json_digest(produced)}, "metadata": {}}
    name = f"records/slicing-{text_sha256('its inputs')}"
    store_of(ws).put(name, json.dumps(record).encode())


def _settle_dead(ws: Workspace, run: str) -> None:
    with taken_from_dead(ws, run) as record:
        if record is not None:
            lines, _end = journal_of(ws, run).lines()
            if lines and record.ended_at is None and not is_in_ledger(ws, run, STRUCTURE):
                append_run(ws, run, STRUCTURE, [stage_run_row(run, "e0")])
            end_record(ws, run, finished=False)
            remove_record(ws, run)


def _raise_alarms(ws: Workspace) -> None:
    """Put down the alarms that the log does not have: who decides holds the lock from reading to writing."""
    with publish_lock(ws):
        there = len(files_of(ws, ALARM_EVENTS))
        rows = [
            replace(alarm_event_row(UNNUMBERED, hours=hour), alarm=f"lean/{name}")
            for hour, name in enumerate(ALARMS)
        ]
        append_alarm_events(ws, rows[there:])


def _in_child(work: Callable[[], object]) -> int:
    """Do something in a child; gives its exit status as ``os.waitpid`` does."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            work()
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
    return os.waitpid(child, 0)[1]


def _told_by_child(work: Callable[[], Sequence[str]], told: Path) -> list[str]:
    status = _in_child(lambda: told.write_text(json.dumps(list(work())), encoding="utf-8"))
    return [f"a child ended with status {status}"] if status else list(json.loads(told.read_text("utf-8")))


def _watched(ws: Workspace, kill_at: int) -> list[str]:
    steps = Steps(ws.root, kill_at)
    steps.watch()
    write_run(ws, f"run-{kill_at}")
    return steps.done


def _faults(ws: Workspace, before: Sequence[dict[str, Rows]], wanted: Content, run: str) -> list[str]:
    """What is wrong after a kill, and after the next run."""
    shown = shown_epochs(ws)
    old, new = before
    found = [
        f"before recovery the catalog shows {epoch} in part"
        for epoch, rows in shown.items()
        if rows not in (old.get(epoch), new.get(epoch))
    ]
    found += [f"before recovery the catalog lost {epoch}" for epoch in old if epoch not in shown]
    lines = journal_of(ws, run).lines()[0] if run in runs_on_record(ws) else []
    write_run(ws, "next")
    found += [f"not as undisturbed: {name}" for name in _differences(content_of(ws), wanted)]
    if shown_epochs(ws) != new:
        found.append("the catalog does not show what the undisturbed run gives")
    if lines and not is_in_ledger(ws, run, STRUCTURE):
        found.append("the ledger does not know the killed run")
    return found + left_behind(ws)


def _differences(found: Content, wanted: Content) -> list[str]:
    return [name for name in RESULTS if getattr(found, name) != getattr(wanted, name)]


def kill_at_steps(folder: Path, every: int, seed: int) -> dict[str, object]:
    """Kill the writing at each step, or at one of so many from a drawn one on; gives the figures."""
    began_s = time.monotonic()
    old, new = open_workspace(folder / "old"), folder / "new"

    def prepare() -> None:
        fill(old)
        rebuild_catalog(old)

    assert _in_child(prepare) == 0
    shutil.copytree(old.root, new)
    steps = _told_by_child(lambda: _watched(Workspace(new), 0), folder / "told.json")
    start = random.Random(seed).randrange(every) + 1
    faults: dict[str, list[str]] = {}
    killed = list(range(start, len(steps) + 1, every))
    for number in killed:
        found = _faults_of_kill(folder, Workspace(folder / "killed"), number)
        if found:
            faults[f"{number}: {steps[number - 1]}"] = found
    seconds = round(time.monotonic() - began_s, 1)
    return {"steps": len(steps), "killed": len(killed), "faults": faults, "seconds": seconds}


def _faults_of_kill(folder: Path, ws: Workspace, number: int) -> list[str]:
    shutil.rmtree(ws.root, ignore_errors=True)
    shutil.copytree(folder / "old", ws.root)
    status = _in_child(lambda: _watched(ws, number))
    if not os.WIFSIGNALED(status):
        return [f"the writer was not killed, it ended with status {status}"]

    def look() -> list[str]:
        old, new = Workspace(folder / "old"), Workspace(folder / "new")
        return _faults(ws, (shown_epochs(old), shown_epochs(new)), content_of(new), f"run-{number}")

    return _told_by_child(look, folder / "told.json")


def kill_at_steps_apart(folder: Path, every: int, seed: int) -> dict[str, object]:
    """The same in a process of its own, which has opened no catalog and no thread yet."""
    folder.mkdir(parents=True, exist_ok=True)
    words = [sys.executable, "-m", "tests.faults.killing.storage_steps", str(folder), str(every), str(seed)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(done.stderr[-2000:])
    figures: dict[str, object] = json.loads(done.stdout.splitlines()[-1])
    return figures


if __name__ == "__main__":
    told = kill_at_steps(Path(sys.argv[1]).resolve(), *(int(word) for word in sys.argv[2:4]))
    sys.stdout.write(f"{json.dumps(told)}\n")
