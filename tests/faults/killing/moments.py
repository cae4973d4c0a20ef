"""Kill whole runs at drawn moments, and hold what is left, and what the next run makes of it, against the undisturbed."""

import random
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from flows.journal_lines import StageAsked, read_line
from storage.catalog import is_current
from storage.ledger import is_in_ledger
from storage.parquet import read_rows
from storage.records import StageRunRow
from storage.run_record import journal_of, read_record, runs_on_record
from storage.tables import RUNS, files_of, table_path
from storage.workspace import Workspace
from tests.faults.killing.forked import Forker
from tests.faults.killing.processes import (
    Ended,
    Moment,
    environment_of_runs,
    kill_processes_of,
    outlive,
    processes_of,
    run_to_its_end_or,
)
from tests.faults.killing.scenes import Scene, campaigns_in, copy_with_stamps
from tests.faults.killing.stored import RESULTS, Content, Rows, content_of, left_behind, shown_epochs
from tests.flows.campaigns import STRUCTURE

SERVERS: Final = {"kept": 6, "killed": 1, "left alone": 1}
"""What becomes of the workflow server, with how often: kept for the next runs, killed with the run, or left to end.

To start one takes longer than the run.
"""

OWN_START: Final = 0.2
"""So many of the killed runs begin as a process of their own; the others are forked off one that has imported all."""

KEPT_S: Final = 900.0

BEYOND: Final = 1.1
"""Moments are drawn up to so many times of the undisturbed run."""

PATIENCE_S: Final = 60.0
"""A server looks twice a second whether it is wanted; a loaded machine is slower."""

NEVER: Final = Moment()


@dataclass(slots=True)
class Undisturbed:
    """A scene, how its run ends when nobody disturbs it, and what it gives."""

    scene: Scene
    ended: Ended
    old: dict[str, Rows]
    new: dict[str, Rows]
    content: Content


@dataclass(slots=True)
class Figures:
    """What was found."""

    moments: int = 0
    phases: Counter[str] = field(default_factory=Counter)
    scenes: Counter[str] = field(default_factory=Counter)
    servers: Counter[str] = field(default_factory=Counter)
    moved_on: Counter[str] = field(default_factory=Counter)
    """Fifths of the undisturbed run, by the part of the steps or processor time at which it was killed."""
    starts: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    seconds: float = 0.0
    last_server: str = "kept"

    def add(self, scene: str, kill: "_Drawn", found: Sequence[str]) -> None:
        """Count one more kill."""
        label = f"{scene}, at {kill.part:.3f}, {kill.moment}, server {kill.server}"
        self.faults += [f"moment {self.moments}, {label}: {fault}" for fault in found]
        self.moments += 1
        self.scenes[scene] += 1
        self.servers[kill.server] += 1
        self.starts["a process of its own" if kill.forker is None else "forked"] += 1
        self.moved_on[f"{int(kill.part * 5) / 5:.1f}"] += 1
        self.last_server = kill.server


@contextmanager
def forker_of(folder: Path) -> Iterator[Forker]:
    """What the runs of the scenes in a folder are forked off; afterwards nothing of them is alive."""
    place = folder / "ws"
    forker = Forker(place, environment_of_runs(0.0))
    try:
        yield forker
    finally:
        forker.end()
        kill_processes_of(place)


def prepared_scenes(folder: Path, forker: Forker) -> Iterator[Undisturbed]:
    """Make the three scenes, each with its undisturbed run."""
    one, two, changed = campaigns_in(folder / "scans")
    place = folder / "ws"
    # the first of all may have to compile: it is not the one whose moments are drawn
    _undisturbed(Scene("one epoch", one, ("--only-new",), None, place), folder / "after-one", forker)
    yield _undisturbed(Scene("first run", two, (), None, place), folder / "after-first", forker)
    replaced = Scene("replaced", changed, (), folder / "after-first", place)
    yield _undisturbed(replaced, folder / "after-replaced", forker)
    if not any((folder / "after-replaced" / "versions").rglob("*.parquet")):
        raise AssertionError("the run with another setting replaced nothing")
    added = Scene("one epoch more", two, ("--only-new",), folder / "after-one", place)
    yield _undisturbed(added, folder / "after-added", forker)


def _undisturbed(scene: Scene, kept: Path, forker: Forker) -> Undisturbed:
    scene.restore(keep_home=True)
    old = shown_epochs(scene.place)
    ended = run_to_its_end_or(NEVER, scene.command, scene.workspace, KEPT_S, forker)
    if ended.exit_code < 0 or ended.exit_code in (1, 2) or not shown_epochs(scene.place):
        raise AssertionError(
            f"the undisturbed run of {scene.name} ended with {ended.exit_code}: {ended.messages}"
        )
    copy_with_stamps(scene.workspace, kept)
    return Undisturbed(scene, ended, old, shown_epochs(scene.place), content_of(scene.place))


@dataclass(frozen=True, slots=True)
class _Drawn:
    """One kill: when, and of what."""

    moment: Moment
    part: float
    server: str
    forker: Forker | None
    """What the killed run is forked off; None where it is a process of its own from the start."""


def kill_at_moments(
    scenes: Sequence[Undisturbed], forker: Forker, moments: int, seed: int, figures: Figures
) -> Iterator[None]:
    """Kill so many runs, one after the other; gives control back after each."""
    drawn = random.Random(seed)
    began_s = time.monotonic()
    of_each = -(-moments // len(scenes))
    # one moment in each of equal parts, so that they spread however few there are
    parts = {one.scene.name: drawn.sample(range(of_each), of_each) for one in scenes}
    for number in range(moments):
        undisturbed = scenes[number % len(scenes)]
        stratum = parts[undisturbed.scene.name][number // len(scenes)]
        kill = _draw(undisturbed.ended, BEYOND * (stratum + drawn.random()) / of_each, forker, drawn)
        found = _tried(undisturbed, kill, forker, figures)
        figures.add(undisturbed.scene.name, kill, found)
        figures.seconds = round(time.monotonic() - began_s, 1)
        yield


def _draw(ended: Ended, part: float, forker: Forker, drawn: random.Random) -> _Drawn:
    """A moment at a part of a run: by its steps, or by its processor time, which a loaded machine does not stretch."""
    by_step, wait_s = drawn.random() < 0.5, drawn.expovariate(10.0)
    (server,) = drawn.choices(list(SERVERS), weights=list(SERVERS.values()))
    alone = drawn.random() < OWN_START
    if by_step and part < 1.0:
        moment = Moment(step=1 + int(part * ended.steps))
    else:
        moment = Moment(cpu_s=part * (ended.cpu_s + alone * forker.start_cpu_s), wait_s=wait_s)
    return _Drawn(moment, part, server, None if alone else forker)


def _tried(undisturbed: Undisturbed, kill: _Drawn, forker: Forker, figures: Figures) -> list[str]:
    scene, kept = undisturbed.scene, kill.server == "kept"
    keep_s = KEPT_S if kept else 0.0
    if not kept or figures.last_server != "kept":
        kill_processes_of(scene.workspace)
    scene.restore(keep_home=kill.server != "killed")
    first = run_to_its_end_or(kill.moment, scene.command, scene.workspace, keep_s, kill.forker)
    if kill.server == "killed":
        kill_processes_of(scene.workspace)
    figures.phases[_phase(scene.place, first)] += 1
    found = _faults_before_recovery(undisturbed)
    killed = _killed_runs(scene.place)
    again = run_to_its_end_or(NEVER, scene.command, scene.workspace, keep_s, forker)
    if again.exit_code != undisturbed.ended.exit_code:
        found.append(f"the next run ended with {again.exit_code}: {again.messages[-600:]}")
    if kept:
        alive = len(processes_of(scene.workspace))
        found += [f"{alive} processes are alive where one server is to be kept"] if alive > 1 else []
    else:
        found += outlive(scene.workspace, PATIENCE_S)
    return found + _faults_after_recovery(undisturbed, killed)


def _faults_before_recovery(undisturbed: Undisturbed) -> list[str]:
    try:
        shown = shown_epochs(undisturbed.scene.place)
    except Exception as fault:
        return [f"the catalog cannot be read: {type(fault).__name__}: {fault}"]
    old, new = undisturbed.old, undisturbed.new
    part = [epoch for epoch, rows in shown.items() if all(rows != state.get(epoch) for state in (old, new))]
    found = [f"before recovery the catalog shows {epoch} in part" for epoch in part]
    return found + [f"before recovery the catalog lost {epoch}" for epoch in old if epoch not in shown]


def _faults_after_recovery(undisturbed: Undisturbed, killed: Sequence[str]) -> list[str]:
    ws = undisturbed.scene.place
    content, wanted = content_of(ws), undisturbed.content
    found = [
        f"not as undisturbed: {name}" for name in RESULTS if getattr(content, name) != getattr(wanted, name)
    ]
    if shown_epochs(ws) != undisturbed.new:
        found.append("the catalog does not show what the undisturbed run gives")
    for run in killed:
        if not is_in_ledger(ws, run, STRUCTURE) or not _is_told_cut(ws, run):
            found.append(f"the ledger does not say what became of the killed run {run}")
        if run in runs_on_record(ws):
            found.append(f"the record of the killed run {run} is still there")
    return found + left_behind(ws)


def _killed_runs(ws: Workspace) -> list[str]:
    """Runs that were cut short and had begun a stage."""
    records = [record for run in runs_on_record(ws) if (record := read_record(ws, run)) is not None]
    dead = [record.run for record in records if record.ended_at is None]
    return [run for run in dead if _stages(ws, run) and not is_in_ledger(ws, run, STRUCTURE)]


def _is_told_cut(ws: Workspace, run: str) -> bool:
    rows = read_rows(table_path(ws, RUNS, STRUCTURE, run), RUNS, StageRunRow)
    return any(row.outcome == "failed" and "cut short" in (row.reason or "") for row in rows)


def _stages(ws: Workspace, run: str) -> list[StageAsked | StageRunRow]:
    told = [read_line(line) for line in journal_of(ws, run).lines()[0]]
    return [line for line in told if isinstance(line, StageAsked | StageRunRow)]


def _phase(ws: Workspace, ended: Ended) -> str:
    """Where a run was when it was killed."""
    if ended.exit_code >= 0:
        return "after its end"
    if ws.journal.exists():
        return "in a publication"
    stages = [line for run in runs_on_record(ws) for line in _stages(ws, run)]
    if not stages:
        return "after its last stage" if _has_ended_record(ws) else "before the first stage"
    if not is_current(ws) and any(files_of(ws, "epochs")):
        return "between publication and catalog"
    return "in a stage" if isinstance(stages[-1], StageAsked) else "between stages"


def _has_ended_record(ws: Workspace) -> bool:
    records = [read_record(ws, run) for run in runs_on_record(ws)]
    return any(record is not None and record.ended_at is not None for record in records)
