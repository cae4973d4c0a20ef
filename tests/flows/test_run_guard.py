"""Retries of epochs that met a fault, and what the ledger says of a run that was cut short."""

from collections.abc import Sequence
from datetime import UTC, datetime

from flows.cut_short import rows_of_cut_run
from flows.journal_lines import StageAsked, asked_line, outcome_line, row_line
from flows.outcome import EpochOutcome
from flows.run_guard import RunGuard, with_retries
from tests.storage.campaign import stage_run_row

AT = datetime(2026, 3, 1, 6, tzinfo=UTC)


def outcome(epoch: str, *, fault: str | None = None, bad_input: bool = False) -> EpochOutcome:
    return EpochOutcome(epoch, "failed" if fault or bad_input else "ok", (), bad_input, fault=fault)


def asked(epoch: str, stage: str) -> StageAsked:
    return StageAsked(epoch, stage, AT, f"{stage}-key", "code")


def test_only_epochs_that_met_a_fault_are_tried_again_and_not_more_often_than_asked() -> None:
    calls: list[list[str]] = []

    def process(epochs: Sequence[str]) -> list[EpochOutcome]:
        calls.append(list(epochs))
        made = {
            "good": outcome("good"),
            "bad": outcome("bad", bad_input=True),
            "ever": outcome("ever", fault="sky fell"),
            "once": outcome("once", fault="sky fell" if len(calls) == 1 else None),
        }
        return [made[epoch] for epoch in epochs]

    found = with_retries(process, ["good", "once", "bad", "ever"], RunGuard(60.0, retries=3))
    assert calls == [["good", "once", "bad", "ever"], ["once", "ever"], ["ever"], ["ever"]]
    assert [(each.epoch, each.state) for each in found] == [
        ("good", "ok"),
        ("once", "ok"),
        ("bad", "failed"),
        ("ever", "failed"),
    ]


def test_a_stage_that_was_under_way_failed_and_those_before_it_are_as_they_ended() -> None:
    done = stage_run_row("run-1", "e0")
    lines = [asked_line(asked("e0", done.stage)), row_line(done), asked_line(asked("e0", "axis"))]
    first, cut = rows_of_cut_run("run-1", done.structure, lines, "the power went")
    assert first == done
    assert (cut.stage, cut.outcome, cut.reason) == ("axis", "failed", "the power went")
    assert (cut.seconds, cut.started_at, cut.cache_key) == (None, AT, "axis-key")


def test_a_run_cut_between_stages_has_a_row_that_says_so() -> None:
    done = stage_run_row("run-1", "e0")
    lines = [asked_line(asked("e0", done.stage)), row_line(done), outcome_line(outcome("e0"))]
    cut = rows_of_cut_run("run-1", done.structure, lines, "the power went")[-1]
    assert (cut.epoch, cut.stage, cut.reason) == ("e0", "run", "the power went")


def test_a_run_that_was_cut_before_its_first_stage_has_no_rows() -> None:
    assert rows_of_cut_run("run-1", "chimney-01", [], "the power went") == []


def test_a_line_of_another_version_is_passed_over() -> None:
    done = stage_run_row("run-1", "e0")
    lines = [{"row": {"stage": "unknown"}}, {"later": 1}, row_line(done)]
    assert rows_of_cut_run("run-1", done.structure, lines, "the power went") == [done]
