"""Whole runs whose workspace lies on a drive that is full, read-only, slow or gone; and what has to come of them."""

import contextlib
import io
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from flows.cli import main
from flows.terminal import Terminal, use_terminal
from storage.workspace import Workspace
from storage.writers import mark_of_this_process
from tests.faults.killing.file_steps import Steps, kill_this_process
from tests.faults.killing.stored import RESULTS, Content, Rows, content_of, left_behind, shown_epochs
from tests.faults.small_drive import Drive
from tests.flows.calls import Called

MEGABYTES: Final = 48

NEVER: Final = 0


@dataclass(frozen=True)
class Undisturbed:
    """What a run of a campaign file gives when nobody disturbs it, and how many steps it takes."""

    code: int
    content: Content
    shown: dict[str, Rows]
    steps: int


@dataclass(frozen=True)
class DriveSite:
    """A folder with campaign files and scans, and a drive with the workspace."""

    scans: Path
    drive: Drive

    @property
    def workspace(self) -> Path:
        return self.drive.place / "ws"

    @property
    def place(self) -> Workspace:
        return Workspace(self.workspace)

    def call(self, command: str, campaign: str, *words: object) -> Called:
        """Call the command line in this process; no traceback may reach the screen."""
        return call([command, self.scans / campaign, *words, "--workspace", self.workspace])

    def run(self, campaign: str) -> Called:
        return self.call("run", campaign)

    def faults_after(self, campaign: str, wanted: Undisturbed) -> list[str]:
        """What the next run makes of a workspace that is not as it would be without the fault; empty where all is well."""
        again = self.run(campaign)
        ended = [] if again.code == wanted.code else [f"the next run ended with {again.code}: {again.err}"]
        content = content_of(self.place)
        different = [name for name in RESULTS if getattr(content, name) != getattr(wanted.content, name)]
        if shown_epochs(self.place) != wanted.shown:
            different.append("what the catalog shows")
        # a temp that could not be removed is swept when its process is gone; here that is the one of the tests
        mark = f".{mark_of_this_process()}."
        left = [each for each in left_behind(self.place) if mark not in each]
        return ended + [f"not as undisturbed: {name}" for name in different] + left

    def epochs_in_part(self, *whole: dict[str, Rows]) -> list[str]:
        """Epochs that the catalog shows as they are in none of the whole states."""
        shown = shown_epochs(self.place)
        return [epoch for epoch, rows in shown.items() if all(rows != state.get(epoch) for state in whole)]


def call(words: Sequence[object]) -> Called:
    """Call the command line in this process; no traceback may reach the screen."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main([str(word) for word in words])
        finally:
            use_terminal(Terminal())
    assert "Traceback" not in out.getvalue() + err.getvalue()
    return Called(code, out.getvalue(), err.getvalue())


@contextmanager
def at_step(
    workspace: Path, number: int, deed: Callable[[], None] = kill_this_process, pause_s: float = 0.0
) -> Iterator[Steps]:
    """Do something before a step that this process takes in a workspace (from 1; 0: never), or make every step slow."""
    sync = os.fsync
    steps = Steps(workspace, number, deed=deed, pause_s=pause_s)
    steps.watch()
    try:
        yield steps
    finally:
        os.fsync = sync
        # what hears of steps stays until the process ends: it must not hold what the test made
        steps.kill_at, steps.deed, steps.pause_s = NEVER, kill_this_process, 0.0
