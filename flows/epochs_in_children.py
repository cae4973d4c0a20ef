"""The epochs of a campaign in a child process: one that takes too long, or dies, is ended and the others go on.

One child processes epoch after epoch; only where it had to be ended does another take over what is left, so a
campaign of a hundred epochs that are all in the cache pays for one start and not for a hundred.
"""

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from prefect.client.orchestration import get_client

from flows.child_process import LOOK_EVERY_S, Child, how_it_ended, started_child
from flows.cut_short import cut_row, row_between_stages
from flows.epochs_child import ChildRequest
from flows.epochs_loop import EpochsRequest
from flows.flow_run_states import crash_epochs_of
from flows.journal_lines import ScansSeen, StageAsked, read_line
from flows.ledger import RunLedger, current_ledger
from flows.outcome import EpochOutcome
from storage.records import StageRunRow
from storage.run_record import RunJournal, journal_of
from storage.workspace import Workspace

ROOT: Final = Path(__file__).resolve().parents[1]
"""The checkout: where the child finds our packages."""


def process_in_children(request: EpochsRequest, place: Workspace, time_limit_s: float) -> list[EpochOutcome]:
    """Process epochs in a child; needs the ledger of a run in ``current_ledger``.

    The time of an epoch begins with its first stage: waiting for another run of the same epoch does not count.
    """
    ledger = current_ledger.get()
    outcomes: dict[str, EpochOutcome] = {}
    while left := [epoch for epoch in request.epochs if epoch not in outcomes]:
        asked = ChildRequest(
            request.campaign_file,
            request.workspace,
            left,
            request.schemes,
            ledger.run,
            ledger.structure,
            ledger.scans,
        )
        outcomes.update(_one_child(asked, ledger, journal_of(place, ledger.run), time_limit_s))
    return [outcomes[epoch] for epoch in request.epochs]


def _one_child(
    asked: ChildRequest, ledger: RunLedger, journal: RunJournal, time_limit_s: float
) -> Mapping[str, EpochOutcome]:
    """What one child made of the epochs; at least one of them has an outcome."""
    _lines, begin = journal.lines()
    follower = _Follower(ledger, journal, begin)
    ended_well = False
    try:
        with started_child(asked.command(), environment=_environment()) as child:
            _wait(child, follower, time_limit_s)
            outcome = child.outcome()
        follower.read()
        ended_well = outcome.ok
        if not ended_well:
            reason = how_it_ended(outcome, time_limit_s)
            fault = f"{reason}\n{outcome.stderr_tail}"
            for epoch in follower.fallen(asked.epochs, time_limit_s if outcome.timed_out else None):
                follower.put_down_cut(epoch, reason)
                follower.outcomes[epoch] = EpochOutcome(
                    epoch, "failed", (reason,), bad_input=False, fault=fault
                )
    finally:
        if not ended_well:
            crash_epochs_of(asked.run, "the process of this run was ended")
    return follower.outcomes


def _wait(child: Child, follower: "_Follower", time_limit_s: float) -> None:
    """Read along until the child ends; end it when an epoch is over its time."""
    while child.running:
        follower.read()
        if any(seconds > time_limit_s for seconds in follower.times_s().values()):
            child.stop_at_limit()
        time.sleep(LOOK_EVERY_S)


@dataclass(slots=True)
class _Follower:
    """Reads the journal that a child writes, and tells the ledger of this process."""

    ledger: RunLedger
    journal: RunJournal
    read_to: int
    outcomes: dict[str, EpochOutcome] = field(default_factory=dict)
    under_way: dict[tuple[str, str], StageAsked] = field(default_factory=dict)
    last: dict[str, StageAsked] = field(default_factory=dict)
    began_s: dict[str, float] = field(default_factory=dict)

    def read(self) -> None:
        """Take in what is new."""
        lines, self.read_to = self.journal.lines(self.read_to)
        for line in lines:
            match read_line(line):
                case StageAsked() as asked:
                    self.began_s.setdefault(asked.epoch, time.monotonic())
                    self.under_way[asked.epoch, asked.stage] = self.last[asked.epoch] = asked
                    self.ledger.begin(asked.epoch, asked.stage)
                case StageRunRow() as row:
                    self.under_way.pop((row.epoch, row.stage), None)
                    self.ledger.take(row)
                case EpochOutcome() as outcome:
                    self.outcomes[outcome.epoch] = outcome
                case ScansSeen(scans):
                    self.ledger.scans.update(scans)

    def times_s(self) -> dict[str, float]:
        """How long the epochs that are under way have taken."""
        now = time.monotonic()
        return {epoch: now - began for epoch, began in self.began_s.items() if epoch not in self.outcomes}

    def fallen(self, epochs: Sequence[str], time_limit_s: float | None) -> list[str]:
        """The epochs that a child fell over: those over their time, else those under way, else all that are left."""
        under_way = self.times_s()
        if time_limit_s is not None:
            return [epoch for epoch, seconds in under_way.items() if seconds > time_limit_s]
        return list(under_way) or [epoch for epoch in epochs if epoch not in self.outcomes]

    def put_down_cut(self, epoch: str, reason: str) -> None:
        """Put the stages that an epoch was in down as failed."""
        run, structure = self.ledger.run, self.ledger.structure
        stages = [asked for (of, _stage), asked in self.under_way.items() if of == epoch]
        for asked in stages:
            del self.under_way[epoch, asked.stage]
            self.ledger.put_down(cut_row(run, structure, asked, reason))
        if not stages and epoch in self.last:
            self.ledger.put_down(row_between_stages(run, structure, self.last[epoch], reason))


def _environment() -> dict[str, str]:
    """Environment of the child: the same server, also where this process started one for itself."""
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("PREFECT__")}
    path = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    with get_client(sync_client=True) as client:
        server = str(client.api_url).rstrip("/")
    return {**inherited, "PYTHONPATH": os.pathsep.join(path), "PREFECT_API_URL": server}
