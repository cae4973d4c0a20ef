"""Alarms with what to type about them, and runs as bars."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from dashboard.content.alarms import commands, counts, courses, in_words, narrowed, quantity
from dashboard.content.runs import bars, runs_of
from dashboard.figures.alarms import course_of_values
from dashboard.figures.runs import timeline
from flows.alarm_command import Person, Remark
from storage.records import AlarmRow, StageRunRow
from tests.storage.campaign import STRUCTURE, alarm_event_row, epoch_time, stage_run_row
from tests.storage.samples import bare_row

NOW = datetime(2026, 1, 1, tzinfo=UTC)


def alarm(name: str, **changed: object) -> AlarmRow:
    row = replace(
        bare_row(AlarmRow),
        structure=STRUCTURE,
        alarm=name,
        rule="limit",
        severity="alarm",
        state="new",
        raised_at=NOW,
    )
    return replace(row, **changed)


def test_the_command_line_names_the_file_and_quotes_what_a_shell_would_read() -> None:
    row = alarm("moved-e 0; rm")
    lines = [command.line for command in commands(row, "my campaign.toml")]
    assert (
        lines[0] == "tiltwatch acknowledge 'my campaign.toml' 'moved-e 0; rm' --name 'YOUR NAME' --note 'WHY'"
    )
    assert [line.split()[1] for line in lines] == ["acknowledge", "mute", "close"]
    assert commands(row, None)[0].line.startswith("tiltwatch acknowledge FILE ")


@pytest.mark.parametrize(
    ("state", "possible"),
    [("acknowledged", ["mute", "close"]), ("muted", ["unmute", "close"]), ("closed", [])],
)
def test_only_what_makes_sense_can_be_typed(state: str, possible: list[str]) -> None:
    assert [command.line.split()[1] for command in commands(alarm("a", state=state), "f")] == possible


def test_the_options_are_those_of_the_program() -> None:
    assert Person.__metadata__[0].name == ("--name",)
    assert Remark.__metadata__[0].name == ("--note",)


def test_open_alarms_are_those_that_nobody_closed_or_muted_the_gravest_first() -> None:
    rows = [
        alarm("w", severity="warning"),
        alarm("a"),
        alarm("m", state="muted"),
        alarm("c", state="closed", rule="moved"),
        alarm("k", state="acknowledged", severity="info"),
    ]
    assert [row.alarm for row in narrowed(rows, "open", None)] == ["a", "w", "k"]
    assert [row.alarm for row in narrowed(rows, "all", "moved")] == ["c"]
    assert counts(rows) == {"open": 3, "muted": 1, "closed": 1, "all": 5}


def test_a_state_says_until_when_and_whether_it_eased() -> None:
    assert in_words(alarm("a", state="muted")) == "muted for good"
    assert in_words(alarm("a", state="muted", muted_until=NOW)) == "muted until 2026-01-01 00:00 UTC"
    assert in_words(alarm("a", eased_at=NOW)) == "new, eased"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.0605, "m", "60.5 mm"),
        (0.0012, "m/a", "1.20 mm a year"),
        (5.0, "1", "5"),
        (300.0, "deg", "300°"),
        (2.0, "x", "2 x"),
    ],
)
def test_quantities_are_written_with_their_unit(value: float, unit: str, text: str) -> None:
    assert quantity(value, unit) == text


def test_the_course_of_an_alarm_has_its_newest_value_of_each_epoch() -> None:
    events = [
        replace(alarm_event_row("1"), value=0.04),
        replace(alarm_event_row("2", "updated"), value=0.06),
        replace(alarm_event_row("3", "acknowledged"), value=0.9),
        replace(alarm_event_row("4"), epoch=None),
    ]
    found = courses(events, {"e0": epoch_time(0)})
    (step,) = found["movement-e0"]
    assert (step.value, step.ratio) == (0.06, pytest.approx(3.0))
    assert list(course_of_values(found, None).data[0].y) == [pytest.approx(3.0)]
    assert course_of_values(found, "another").data[0].opacity < 1.0


def stage(name: str, seconds: float | None, after_s: float = 0.0, **changed: object) -> StageRunRow:
    row = stage_run_row("run-1", "e0")
    later = row.started_at + timedelta(seconds=after_s)
    state = "cached" if seconds is None else "computed"
    return replace(row, stage=name, state=state, seconds=seconds, started_at=later, **changed)


def test_a_run_sums_what_its_stages_tell() -> None:
    rows = [
        stage("ingest ST01", 2.0, peak_rss_mb=100.0),
        stage("axis A/paper", 1.5, 3.0, peak_rss_mb=300.0, outcome="refused"),
        stage("axis B/paper", None, 4.0),
        replace(stage("ingest ST01", None, 100.0), run="run-2", epoch="e1"),
    ]
    newest, first = runs_of(rows)
    assert (first.computed, first.cached, first.refused, first.failed) == (2, 1, 1, 0)
    assert (first.seconds, first.peak_rss_mb, first.epochs) == (3.5, 300.0, ("e0",))
    assert (newest.run, newest.seconds, newest.peak_rss_mb) == ("run-2", None, None)
    assert runs_of([]) == []


def test_bars_stand_where_their_stage_ran_and_refusals_are_crosses() -> None:
    rows = [
        stage("axis <A>", 1.0, 5.0, outcome="refused", reason="<i>bad</i>"),
        stage("ingest ST01", 2.0),
        stage("slicing A", None, 2.0),
    ]
    found = bars(rows)
    assert [(bar.stage, bar.from_s) for bar in found] == [
        ("ingest ST01", 0.0),
        ("slicing A", 2.0),
        ("axis <A>", 5.0),
    ]
    figure = timeline(found)
    drawn = {trace.name: trace for trace in figure.data}
    assert list(drawn["axis"].base) == [5.0]
    assert list(drawn["axis"].x) == [1.0]
    assert list(drawn["from the cache"].y) == [1]
    assert "&lt;i&gt;bad&lt;/i&gt;" in drawn["refused or failed"].customdata[0][0]
    assert figure.layout.yaxis.ticktext[2] == "axis &lt;A&gt;"
