"""Run the flow for complete epochs, one after the other, each in a process of its own with a time limit."""

import json
import math
import os
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from flows.child_process import Child, ChildOutcome, how_it_ended, started_child
from flows.watch.events import Now, Teller, WatchEvent
from flows.watch.place import WatchPlace
from storage.digests import file_sha256
from storage.errors import StorageError
from storage.intake import intake_file, read_run_note, write_run_note
from tasks.settings.intake import Intake

BAD_INPUT: Final = 3
SETTLED_CODES: Final = frozenset({0, BAD_INPUT})
"""A run that ended so would end so again; others are tried again when the watch starts anew."""

AGAIN_AFTER_S: Final = 300.0
"""So long after a run that met a full or absent drive it is tried again: there may be room by then."""

ROOT: Final = Path(__file__).resolve().parents[2]


@dataclass(slots=True)
class _UnderWay:
    epoch: str
    intake_sha256: str
    child: Child
    stack: ExitStack


class Runs:
    """Starts a run where an epoch is complete and was not run as it is now, and looks after the one under way."""

    def __init__(self, place: WatchPlace, teller: Teller, now: Now, time_limit_s: float) -> None:
        self._place = place
        self._teller = teller
        self._now = now
        self._time_limit_s = time_limit_s
        self._tried: set[tuple[str, str]] = set()
        self._again_s: dict[tuple[str, str], float] = {}
        self._under_way: _UnderWay | None = None

    @property
    def busy(self) -> bool:
        """Whether a run is under way."""
        return self._under_way is not None

    def follow(self, intakes: Sequence[Intake]) -> bool:
        """End what is over, start what is due; gives whether a run ended."""
        ended = self._look_after()
        if self._under_way is None:
            due = next((intake for intake in intakes if self._is_due(intake)), None)
            if due is not None:
                self._start(due)
        return ended

    def stop(self) -> None:
        """End the run that is under way; what it has finished is kept, and the next watch goes on with it."""
        if self._under_way is not None:
            self._under_way.stack.close()
            self._under_way = None

    def awaits_run(self, intake: Intake) -> bool:
        """Whether an epoch is complete and not run yet as it is."""
        return intake.complete is not None and not self._is_done(intake)

    def _is_due(self, intake: Intake) -> bool:
        key = (intake.epoch, self._sha256(intake))
        may_run = key not in self._tried or time.monotonic() >= self._again_s.get(key, math.inf)
        return may_run and self.awaits_run(intake)

    def _is_done(self, intake: Intake) -> bool:
        note = read_run_note(self._place.workspace, self._place.structure, intake.epoch)
        return (
            note is not None
            and note.get("intake_sha256") == self._sha256(intake)
            and note.get("exit_code") in SETTLED_CODES
        )

    def _sha256(self, intake: Intake) -> str:
        return file_sha256(intake_file(self._place.workspace, self._place.structure, intake.epoch))

    def _start(self, intake: Intake) -> None:
        sha256, stack = self._sha256(intake), ExitStack()
        self._tried.add((intake.epoch, sha256))
        self._again_s.pop((intake.epoch, sha256), None)  # the end of this run says whether there is another
        words = ["run", str(self._place.campaign_file), "--workspace", str(self._place.workspace.root)]
        command = [sys.executable, "-m", "flows.cli", *words, "--epoch", intake.epoch, "--json"]
        paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
        child = stack.enter_context(started_child(command, environment=environment))
        self._under_way = _UnderWay(intake.epoch, sha256, child, stack)
        line = f"{intake.epoch}: run started"
        self._teller.tell(WatchEvent("run-started", (line,), {"epoch": intake.epoch}))

    def _look_after(self) -> bool:
        run = self._under_way
        if run is None:
            return False
        if run.child.running:
            if time.monotonic() - run.child.began_s <= self._time_limit_s:
                return False
            run.child.stop_at_limit()
        outcome = run.child.outcome()
        run.stack.close()
        self._under_way = None
        self._note(run, outcome)
        return True

    def _keep(self, epoch: str, note: Mapping[str, object]) -> None:
        try:
            write_run_note(self._place.workspace, self._place.structure, epoch, note)
        except StorageError as fault:  # the drive is full still: the watch goes on
            self._teller.tell(WatchEvent("error", (f"{epoch}: {fault}",), {"epoch": epoch}))

    def _note(self, run: _UnderWay, outcome: ChildOutcome) -> None:
        answer = _answer_of(outcome)
        state = _state_of(run.epoch, answer)
        facts = {
            "epoch": run.epoch,
            "exit_code": outcome.exit_code,
            "timed_out": outcome.timed_out,
            "seconds": round(outcome.seconds, 1),
            "run": answer.get("run"),
            "state": state,
        }
        note = {**facts, "intake_sha256": run.intake_sha256, "ended_at": self._now().isoformat()}
        again = outcome.exit_code == BAD_INPUT and _failed_by_storage(run.epoch, answer)
        if again:
            self._again_s[run.epoch, run.intake_sha256] = time.monotonic() + AGAIN_AFTER_S
        if outcome.timed_out or again:
            note["exit_code"] = None
        self._keep(run.epoch, note)
        how = (
            f"{state or 'done'} in {outcome.seconds:.0f} s"
            if state
            else how_it_ended(outcome, self._time_limit_s)
        )
        kind = "run-ended" if state else "error"
        self._teller.tell(WatchEvent(kind, (f"{run.epoch}: run ended: {how}",), facts))


def _failed_by_storage(epoch: str, answer: dict[str, object]) -> bool:
    """Whether a run ended by what can be otherwise next time: the drive, or a campaign file that is being edited."""
    told = _told_of(epoch, answer)
    return told is None or told.get("storage_fault") is True


def _answer_of(outcome: ChildOutcome) -> dict[str, object]:
    """The object that a run writes last; empty where it was ended before."""
    lines = outcome.stdout.strip().splitlines()
    try:
        content = json.loads(lines[-1]) if lines else {}
    except ValueError:
        return {}
    return content if isinstance(content, dict) else {}


def _told_of(epoch: str, answer: dict[str, object]) -> dict[str, object] | None:
    """What the answer says of an epoch; None where the run did not come to it."""
    epochs = answer.get("epochs")
    told = epochs if isinstance(epochs, list) else []
    return next((one for one in told if isinstance(one, dict) and one.get("epoch") == epoch), None)


def _state_of(epoch: str, answer: dict[str, object]) -> str | None:
    told = _told_of(epoch, answer)
    return None if told is None else str(told.get("state"))
