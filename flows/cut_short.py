"""What the ledger says of stages that a run did not finish."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from flows.journal_lines import StageAsked, read_line
from storage.records import StageRunRow
from storage.run_record import Line

WHOLE_RUN: Final = "run"
"""Stands for the stage in the row of a run that was cut short between stages."""


def cut_row(run: str, structure: str, asked: StageAsked, reason: str) -> StageRunRow:
    """Row of a stage that was under way when its process ended."""
    return StageRunRow(
        run=run,
        structure=structure,
        epoch=asked.epoch,
        stage=asked.stage,
        state="computed",
        outcome="failed",
        reason=reason,
        started_at=asked.asked_at,
        seconds=None,
        points=None,
        peak_rss_mb=None,
        code_version=asked.code_version,
        cache_key=asked.cache_key,
    )


def rows_of_cut_run(run: str, structure: str, lines: Iterable[Line], reason: str) -> list[StageRunRow]:
    """Rows of a run that was cut short, from its journal: what ended, and what was under way as failed.

    Where nothing was under way, a row of the stage ``run`` says that it was cut short after the last stage. A run
    that did nothing yet has no rows.
    """
    rows: list[StageRunRow] = []
    under_way: dict[tuple[str, str], StageAsked] = {}
    last: StageAsked | None = None
    for line in lines:
        told = read_line(line)
        if isinstance(told, StageAsked):
            last = under_way[told.epoch, told.stage] = told
        elif isinstance(told, StageRunRow):
            under_way.pop((told.epoch, told.stage), None)
            rows.append(told)
    if last is None:
        return rows
    cut = [cut_row(run, structure, asked, reason) for asked in under_way.values()]
    return rows + (cut or [row_between_stages(run, structure, last, reason)])


def row_between_stages(run: str, structure: str, last: StageAsked, reason: str) -> StageRunRow:
    """Row of a run that was cut short when the stage that was asked for last had ended."""
    return replace(cut_row(run, structure, last, reason), stage=WHOLE_RUN)
