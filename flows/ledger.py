"""The run's own ledger: what every stage did, told and journalled as it happens, stored at the end."""

import secrets
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path

from flows.journal_lines import StageAsked, asked_line, outcome_line, row_line, scans_line
from flows.outcome import EpochOutcome
from storage.ledger import RUN_TIME, newest_run_time
from storage.records import StageRunRow
from storage.run_record import RunJournal
from storage.verified import Stamp
from storage.workspace import Workspace
from tasks.produced import Produced


@dataclass(frozen=True, slots=True)
class StageEvent:
    """A stage began or ended: ``state`` is started, computed, cached, refused or failed."""

    epoch: str
    stage: str
    state: str
    seconds: float | None = None
    points: int | None = None
    detail: str | None = None


@dataclass(frozen=True, slots=True)
class StageDone:
    """How a stage ended, for the ledger; nothing was produced where it failed by a fault."""

    stage: str
    cached: bool
    started_at: datetime
    cache_key: str
    code_version: str
    produced: Produced | None
    fault: str | None = None


@dataclass(slots=True)
class RunLedger:
    """Collects the stages of one run and tells a listener of each."""

    run: str
    structure: str
    listener: Callable[[StageEvent], None]
    rows: list[StageRunRow] = field(default_factory=list)
    scans: dict[str, str] = field(default_factory=dict)
    """Digest of every scan that the run has seen, and whose it was first."""
    digests: dict[tuple[Path, Stamp], str] = field(default_factory=dict)
    """Digest of every scan that the run has hashed, under what would change with its content."""
    journal: RunJournal | None = None
    """Where it is written as it happens, so that a run that is killed can be told of (flows/run_keeping)."""
    passing: set[str] = field(default_factory=set)
    """Epochs of which something could not be read for a reason that may be gone next time: a drive that was away."""
    anew: set[str] | None = None
    """Keys of the stages that were computed anew although they were cached; None where what is cached is taken."""

    def wants_anew(self, cache_key: str) -> bool:
        """Whether a stage is to be computed although it is cached: in a forced run, once."""
        if self.anew is None or cache_key in self.anew:
            return False
        self.anew.add(cache_key)
        return True

    def begin(self, epoch: str, stage: str) -> None:
        """Tell that a stage was asked for."""
        self.listener(StageEvent(epoch, stage, "started"))

    def asked(self, asked: StageAsked) -> None:
        """Put down which stage is under way, so that it is known where a run was cut short."""
        if self.journal is not None:
            self.journal.append(asked_line(asked))

    def note(self, epoch: str, done: StageDone) -> None:
        """Put the end of a stage down."""
        cost = done.produced.cost if done.produced is not None else None
        refusal = done.produced.refusal if done.produced is not None else None
        outcome = "failed" if done.produced is None else "refused" if refusal else "ok"
        state = "cached" if done.cached else "computed"
        self.put_down(
            StageRunRow(
                run=self.run,
                structure=self.structure,
                epoch=epoch,
                stage=done.stage,
                state=state,
                outcome=outcome,
                reason=refusal or done.fault,
                started_at=done.started_at,
                seconds=cost.seconds if cost and not done.cached else None,
                points=cost.points if cost else None,
                peak_rss_mb=cost.peak_rss_mb if cost and not done.cached else None,
                code_version=done.code_version,
                cache_key=done.cache_key,
            )
        )

    def put_down(self, row: StageRunRow) -> None:
        """Add a row, and journal it."""
        if self.journal is not None:
            self.journal.append(row_line(row))
        self.take(row)

    def ended(self, outcome: EpochOutcome) -> None:
        """Put down how an epoch ended, and which scans were seen so far."""
        if self.journal is not None:
            self.journal.append(scans_line(self.scans))
            self.journal.append(outcome_line(outcome))

    def take(self, row: StageRunRow) -> None:
        """Add a row that the journal has already: of a child process of this run."""
        self.rows.append(row)
        told = row.state if row.outcome == "ok" else row.outcome
        self.listener(StageEvent(row.epoch, row.stage, told, row.seconds, row.points, row.reason))

    def count(self, state: str) -> int:
        """How many stages ended so."""
        return sum(row.state == state for row in self.rows)


def new_run_id(ws: Workspace, structure: str) -> str:
    """Make an id that sorts behind those of all runs of a structure before it, and is safe as a file name.

    It tells the time; where the clock was set back, it counts on from the newest id, by a second.
    """
    now, newest = datetime.now(UTC), newest_run_time(ws, structure)
    if newest is not None and newest > now:
        now = newest + timedelta(seconds=1)
    return f"{now:{RUN_TIME}}-{secrets.token_hex(3)}"


current_ledger: ContextVar[RunLedger] = ContextVar("current_ledger")
"""The ledger of the run that is under way in this context; flows called without one make their own."""
