"""Runs of a structure: what each did, and the stages of one as bars over its time."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from storage.records import StageRunRow


@dataclass(frozen=True, slots=True)
class Run:
    """A run as its stages tell.

    ``seconds`` is the sum of the stages that were computed, ``peak_rss_mb`` the largest memory of a process; None where
    all came from the cache. ``began_at`` is when its first stage was asked for.
    """

    run: str
    began_at: datetime
    epochs: tuple[str, ...]
    computed: int
    cached: int
    refused: int
    failed: int
    seconds: float | None
    peak_rss_mb: float | None


def runs_of(rows: Sequence[StageRunRow]) -> list[Run]:
    """The runs of a structure, the newest first: by their ids, which sort as they began also where a clock was set."""
    by_run: dict[str, list[StageRunRow]] = {}
    for row in rows:
        by_run.setdefault(row.run, []).append(row)
    return [_run(name, by_run[name]) for name in sorted(by_run, reverse=True)]


def _run(name: str, rows: Sequence[StageRunRow]) -> Run:
    seconds = [row.seconds for row in rows if row.seconds is not None]
    memory = [row.peak_rss_mb for row in rows if row.peak_rss_mb is not None]
    return Run(
        name,
        min(row.started_at for row in rows),
        tuple(dict.fromkeys(row.epoch for row in sorted(rows, key=lambda row: row.started_at))),
        sum(row.state == "computed" for row in rows),
        sum(row.state == "cached" for row in rows),
        sum(row.outcome == "refused" for row in rows),
        sum(row.outcome == "failed" for row in rows),
        sum(seconds) if seconds else None,
        max(memory, default=None),
    )


@dataclass(frozen=True, slots=True)
class Bar:
    """A stage of a run on its time line.

    ``kind`` is the first word of the stage. ``from_s`` is counted from the first stage; ``seconds`` is None for what came
    from the cache.
    """

    stage: str
    kind: str
    from_s: float
    seconds: float | None
    row: StageRunRow


def bars(rows: Sequence[StageRunRow]) -> list[Bar]:
    """The stages of one epoch of one run, in the order in which they were asked for."""
    ordered = sorted(rows, key=lambda row: (row.started_at, row.stage))
    return [
        Bar(
            row.stage,
            row.stage.split(" ", 1)[0],
            (row.started_at - ordered[0].started_at).total_seconds(),
            row.seconds,
            row,
        )
        for row in ordered
    ]
