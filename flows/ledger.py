"""The run's own ledger: what every stage did, told as it happens and stored at the end."""

import secrets
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass, field
from datetime import UTC, datetime

from storage.records import StageRunRow
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

    def begin(self, epoch: str, stage: str) -> None:
        """Tell that a stage was asked for."""
        self.listener(StageEvent(epoch, stage, "started"))

    def note(self, epoch: str, done: StageDone) -> None:
        """Put the end of a stage down."""
        cost = done.produced.cost if done.produced is not None else None
        refusal = done.produced.refusal if done.produced is not None else None
        outcome = "failed" if done.produced is None else "refused" if refusal else "ok"
        state = "cached" if done.cached else "computed"
        self.rows.append(
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
        last = self.rows[-1]
        told = state if outcome == "ok" else outcome
        self.listener(StageEvent(epoch, done.stage, told, last.seconds, last.points, last.reason))

    def count(self, state: str) -> int:
        """How many stages ended so."""
        return sum(row.state == state for row in self.rows)


def new_run_id() -> str:
    """Make an id that sorts by time and is safe as a file name."""
    return f"{datetime.now(UTC):%Y%m%dT%H%M%SZ}-{secrets.token_hex(3)}"


current_ledger: ContextVar[RunLedger] = ContextVar("current_ledger")
"""The ledger of the run that is under way in this context; flows called without one make their own."""
