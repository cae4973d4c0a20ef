"""The first page says the verdict in words, for every verdict."""

from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from dashboard.report.blocks import Document
from dashboard.report.document import document_of
from dashboard.report.parts.phrases import limit_date
from dashboard.report.words import words_of
from storage.records import TrendRow
from storage.workspace import Workspace, open_workspace
from tests.dashboard.report.reported import document, facts_of, limited, publish
from tests.storage.samples import bare_row

ENGLISH = words_of("en")


def judged(ws: Workspace, allowable_m: float, verdict: str, kind: str = "construction") -> Document:
    """The report of an epoch with that limit."""

    def change(tables: dict[str, list[Any]]) -> None:
        limited(tables, allowable_m, verdict)
        tables["verdicts"] = [replace(row, kind=kind) for row in tables["verdicts"]]

    publish(ws, 2, change)
    return document(ws)


@pytest.fixture
def ws(tmp_path: Path) -> Workspace:
    """An empty workspace."""
    return open_workspace(tmp_path / "ws")


def test_a_limit_that_is_exceeded_names_its_paper_and_by_how_much(english: Document) -> None:
    first = english.first
    assert (first.word, first.tone, first.icon) == ("LIMIT EXCEEDED", "alarm", "▲")
    assert first.limit_label == "Limit: Works rule 12, 2019, 4.2, tolerance of construction"
    assert first.limit == "60.0 mm"
    assert any(
        "The deviation is 868.7 mm above it, 15.5 times what is allowed." in said for said in first.statement
    )
    assert first.next_steps[0].startswith("Have a structural engineer assess stability now")
    assert first.next_steps[1].startswith("This limit is a tolerance of construction.")


def test_a_limit_that_is_kept_says_how_much_is_left(ws: Workspace) -> None:
    first = judged(ws, 2.0, "pass").first
    assert (first.word, first.tone, first.icon) == ("WITHIN THE LIMIT", "ok", "✓")
    assert any("1071.3 mm below it, 46 % of what is allowed." in said for said in first.statement)


def test_a_limit_within_the_uncertainty_cannot_be_told(ws: Workspace) -> None:
    first = judged(ws, 0.928, "cannot tell", "in-service").first
    assert (first.word, first.tone, first.icon) == ("CANNOT TELL", "warning", "◆")
    assert first.next_steps[0].startswith("Measure again with a smaller uncertainty")


def test_a_limit_of_the_measurement_judges_the_measurement(ws: Workspace) -> None:
    first = judged(ws, 0.05, "pass", "measurement").first
    assert first.sentence == "The uncertainty of the measurement keeps what the terms of the survey allow."
    assert any("it is one for the uncertainty of the measurement" in said for said in first.statement)


def test_a_significant_change_asks_for_its_cause(english: Document) -> None:
    change = english.first.cards[0]
    assert change.label == "Change since e0"
    assert change.note.startswith(("significant (p ", "not significant (p "))
    asked = any(step.startswith("Find the cause") for step in english.first.next_steps)
    assert asked == (change.tone == "warning")


def test_a_rate_is_stated_with_the_date_of_the_limit(published: Workspace) -> None:
    facts = facts_of(published)
    now = facts.epoch.epoch_time
    trend = replace(
        bare_row(TrendRow),
        n_epochs=5,
        last_time=now,
        rate_m_per_year=0.01,
        rate_sigma_m_per_year=0.001,
        rate_significant=True,
        limit_m=0.06,
        limit_reached_at=now + timedelta(days=400),
        limit_earliest_at=now + timedelta(days=300),
        limit_latest_at=None,
    )
    rate = document_of(replace(facts, trend=trend), ENGLISH).first.cards[1]
    assert (rate.value, rate.tone) == ("10.0 ± 2.0 mm/a", "warning")
    assert rate.note == "significant; limit reached 2027-04-17 (95 %: 2027-01-07 to never)"
    assert limit_date(replace(trend, limit_m=None), ENGLISH) == "significant; no limit to reach"
    assert limit_date(replace(trend, limit_reached_at=None), ENGLISH).endswith("not reached within 100 years")
    assert limit_date(replace(trend, limit_reached_at=now), ENGLISH).endswith("is exceeded already")
    slow = document_of(replace(facts, trend=replace(trend, rate_significant=False)), ENGLISH).first.cards[1]
    assert "no date can be told" in slow.note


def test_a_trend_that_knows_of_later_epochs_is_left_out(published: Workspace) -> None:
    facts = replace(facts_of(published), trend=None, trend_goes_on=True)
    rate = document_of(facts, ENGLISH).first.cards[1]
    assert (rate.value, rate.note) == ("--", "not stated: the stored trend includes later epochs")
