"""Progress of a run on stderr: bars on a terminal, a line for every finished stage otherwise."""

import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from flows.ledger import StageEvent
from flows.terminal import note, terminal

Listener = Callable[[StageEvent], None]

STARTED: Final = "started"


@contextmanager
def progress() -> Iterator[Listener]:
    """Show the stages of a run as they begin and end."""
    if terminal().quiet:
        yield _ignore
    elif sys.stderr.isatty():
        with _bars() as listener:
            yield listener
    else:
        yield print_stage


def print_stage(event: StageEvent) -> None:
    """Write one line for a stage that ended."""
    if event.state != STARTED:
        note(stage_line(event))


def stage_line(event: StageEvent) -> str:
    """Say how a stage ended, how long it took and at what rate."""
    words = f"{event.epoch} {event.stage}: {event.state}"
    if event.seconds is not None and event.state == "computed":
        words += f" in {event.seconds:.1f} s"
        if event.points and event.seconds > 0.0:
            words += f", {event.points:,} points, {event.points / event.seconds:,.0f} points/s"
    return words + (f": {event.detail}" if event.detail else "")


def _ignore(_event: StageEvent) -> None:
    """Show nothing."""


@contextmanager
def _bars() -> Iterator[Listener]:
    # rich costs 0.1 s that a start for help or a script need not pay
    from rich.console import Console  # noqa: PLC0415
    from rich.progress import Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn  # noqa: PLC0415

    console = Console(stderr=True, no_color=not terminal().color)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console) as shown:
        rows: dict[str, _EpochRow] = {}

        def listen(event: StageEvent) -> None:
            row = rows.setdefault(event.epoch, _EpochRow(event.epoch))
            row.take(event)
            if row.task is None:
                row.task = shown.add_task(row.text(), total=None)
            shown.update(TaskID(row.task), description=row.text())
            if event.state in {"failed", "refused"}:
                shown.console.print(stage_line(event), markup=False, highlight=False)

        yield listen


class _EpochRow:
    """What is known of an epoch's stages: those under way, and how many ended how."""

    def __init__(self, epoch: str) -> None:
        self.epoch = epoch
        self.task: int | None = None
        self.under_way: list[str] = []
        self.ended: Counter[str] = Counter()
        self.rate = ""

    def take(self, event: StageEvent) -> None:
        """Put an event down."""
        if event.state == STARTED:
            self.under_way.append(event.stage)
            return
        if event.stage in self.under_way:
            self.under_way.remove(event.stage)
        self.ended[event.state] += 1
        if event.points and event.seconds:
            self.rate = f", {event.points / event.seconds:,.0f} points/s"

    def text(self) -> str:
        """Say it in one line."""
        ended = ", ".join(f"{count} {state}" for state, count in sorted(self.ended.items()))
        now = self.under_way[-1] if self.under_way else "done"
        return f"{self.epoch}  {now}  {ended}{self.rate}"
