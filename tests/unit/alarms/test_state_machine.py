"""What becomes of alarms: once raised, notably worse, eased, closed; the same record says it once."""

import itertools

import pytest

from tasks.alarms import Point, closing, unmuting
from tasks.alarms.state_machine import follow_apart
from tests.unit.alarms.records import Log, finding, points

HISTORIES = {
    "raised and lasting": (5.0, 11.0, 11.5),
    "worse": (5.0, 11.0, 14.0),
    "slowly worse": (11.0, 12.0, 13.0, 14.0),
    "eased": (11.0, 8.0),
    "between": (11.0, 9.5),
    "twice": (11.0, 8.0, 9.5, 12.0),
    "nothing to tell between": (11.0, None, 8.0),
    "never": (9.5, 10.0, 9.9),
}


@pytest.mark.parametrize("values", HISTORIES.values(), ids=list(HISTORIES))
def test_the_same_record_adds_nothing_a_second_time(values: tuple[float | None, ...]) -> None:
    log = Log()
    log.evaluate(points(*values))
    assert log.evaluate(points(*values)) == []


@pytest.mark.parametrize("values", HISTORIES.values(), ids=list(HISTORIES))
def test_what_was_added_does_not_depend_on_how_many_epochs_were_judged_at_once(
    values: tuple[float | None, ...],
) -> None:
    at_once, one_by_one = Log(), Log()
    at_once.evaluate(points(*values))
    for end in range(1, len(values) + 1):
        one_by_one.evaluate(points(*values[:end]))
    assert [(e.action, e.alarm, e.value) for e in at_once.events] == [
        (e.action, e.alarm, e.value) for e in one_by_one.events
    ]


@pytest.mark.parametrize("values", HISTORIES.values(), ids=list(HISTORIES))
def test_a_crash_between_two_events_is_made_good(values: tuple[float | None, ...]) -> None:
    whole = Log()
    whole.evaluate(points(*values), severity="info")
    for written in range(len(whole.events)):
        cut = Log()
        cut.events = whole.events[:written]
        cut.evaluate(points(*values), severity="info")
        assert [(e.action, e.alarm) for e in cut.events] == [(e.action, e.alarm) for e in whole.events]


def test_an_active_alarm_is_not_raised_again() -> None:
    log = Log()
    assert log.evaluate(points(11.0)) == ["raised rule-e1"]
    assert log.evaluate(points(11.0, 11.0)) == []


def test_an_alarm_that_became_notably_worse_is_updated_once() -> None:
    log = Log()
    log.evaluate(points(11.0))
    assert log.evaluate(points(11.0, 13.1)) == []
    assert log.evaluate(points(11.0, 13.1, 13.3)) == ["updated rule-e1"]
    assert log.alarm("rule-e1").found.epoch == "e3"


def test_a_value_between_the_thresholds_neither_raises_nor_eases() -> None:
    log = Log()
    assert log.evaluate(points(9.5)) == []
    log.evaluate(points(9.5, 11.0))
    assert log.evaluate(points(9.5, 11.0, 9.5)) == []
    assert log.evaluate(points(9.5, 11.0, 9.5, 8.9)) == ["eased rule-e2"]


def test_a_value_at_the_limit_does_not_flap() -> None:
    log = Log()
    values = list(itertools.islice(itertools.cycle([10.1, 9.9]), 40))
    for end in range(1, len(values) + 1):
        log.evaluate(points(*values[:end]))
    assert [e.action for e in log.events] == ["raised"]


def test_an_eased_alarm_waits_for_a_person_and_is_closed_when_one_has_seen_it() -> None:
    log = Log()
    log.evaluate(points(11.0, 8.0))
    assert log.alarm("rule-e1").is_open
    log.by_hand("rule-e1", "acknowledged")
    assert log.evaluate(points(11.0, 8.0)) == ["closed rule-e1"]
    assert log.alarm("rule-e1").closing.note == "eased, and acknowledged"


def test_an_acknowledged_alarm_is_closed_as_soon_as_it_eases() -> None:
    log = Log()
    log.evaluate(points(11.0))
    log.by_hand("rule-e1", "acknowledged")
    assert log.evaluate(points(11.0, 8.0)) == ["eased rule-e1", "closed rule-e1"]


def test_information_needs_no_acknowledgement() -> None:
    log = Log()
    assert log.evaluate(points(11.0, 8.0), severity="info") == [
        "raised rule-e1",
        "eased rule-e1",
        "closed rule-e1",
    ]


def test_a_rule_that_breaks_after_it_had_eased_is_a_new_alarm() -> None:
    log = Log()
    log.evaluate(points(11.0, 8.0))
    assert log.evaluate(points(11.0, 8.0, 11.0)) == ["raised rule-e3"]


def test_a_closed_alarm_is_raised_anew_only_by_a_later_epoch() -> None:
    log = Log()
    log.evaluate(points(11.0, 11.0))
    log.by_hand("rule-e1", "closed", epoch="e2")
    assert log.evaluate(points(11.0, 30.0)) == []
    assert log.evaluate(points(11.0, 11.0, 11.0)) == ["raised rule-e3"]


def test_an_alarm_whose_finding_is_gone_is_closed_by_the_program_and_says_so() -> None:
    log = Log()
    log.evaluate(points(5.0, 11.0))
    assert log.evaluate(points(5.0, 6.0)) == ["closed rule-e2"]
    ended = log.alarm("rule-e2").closing
    assert ended.person is None
    assert ended.note == "the finding is gone: since e2 was computed anew, or the rule changed, 6"


def test_a_finding_that_comes_back_is_a_new_alarm_of_another_name() -> None:
    log = Log()
    log.evaluate(points(11.0))
    log.evaluate(points(6.0))
    assert log.evaluate(points(11.0)) == ["raised rule-e1-2"]


def test_an_alarm_whose_epochs_are_not_stored_any_more_is_closed() -> None:
    log = Log()
    log.evaluate(points(11.0))
    assert log.evaluate(points(6.0, first=2)) == ["closed rule-e1"]
    assert "e1 is not stored any more" in log.alarm("rule-e1").closing.note


def test_an_alarm_that_a_later_epoch_made_worse_stands_although_its_first_epoch_was_corrected() -> None:
    log = Log()
    log.evaluate(points(11.0, 20.0))
    assert log.evaluate(points(6.0, 20.0)) == []


def test_where_nothing_can_be_told_an_alarm_stays_as_it_was() -> None:
    log = Log()
    log.evaluate(points(None, 11.0))
    assert log.evaluate(points(None, None)) == []
    assert log.evaluate(points(None, None, 8.0)) == ["eased rule-e2"]


def test_a_graver_severity_is_told_and_has_to_be_acknowledged_again() -> None:
    log = Log()
    log.evaluate(points(11.0), severity="warning")
    log.by_hand("rule-e1", "acknowledged")
    assert log.alarm("rule-e1").is_acknowledged
    assert log.evaluate(points(11.0), severity="alarm") == ["updated rule-e1"]
    assert not log.alarm("rule-e1").is_acknowledged
    assert log.evaluate(points(11.0), severity="alarm") == []
    assert log.evaluate(points(11.0), severity="info") == []


def test_ids_of_alarms_are_unique_over_all_rules() -> None:
    log = Log()
    log.evaluate([Point("b-c", "b-c", finding(11.0))], rule="a")
    assert log.evaluate([Point("c", "c", finding(11.0))], rule="a-b") == ["raised a-b-c-2"]


def test_points_that_stand_for_themselves_have_alarms_of_their_own() -> None:
    log = Log()
    steps = follow_apart("late", "warning", points(11.0, 8.0, 12.0), [], frozenset())
    log.append(steps)
    assert [e.alarm for e in log.events] == ["late-e1", "late-e3"]
    steps = follow_apart("late", "warning", points(8.0, 8.0), log.alarms, frozenset())
    assert [(step.action, step.alarm) for step in steps] == [("closed", "late-e1")]


def test_a_mute_hides_an_alarm_until_its_time_is_over() -> None:
    log = Log()
    log.evaluate(points(11.0))
    log.by_hand("rule-e1", "muted", until=log.events[-1].happened_at.replace(hour=12))
    alarm = log.alarm("rule-e1")
    assert alarm.is_muted(log.events[0].happened_at)
    assert not alarm.is_muted(log.events[0].happened_at.replace(hour=12))
    log.append([unmuting(alarm)])
    assert log.alarm("rule-e1").mute is None
    log.by_hand("rule-e1", "muted")
    assert log.alarm("rule-e1").is_muted(log.events[0].happened_at.replace(year=2100))


def test_a_closing_of_the_program_names_no_person() -> None:
    log = Log()
    log.evaluate(points(11.0))
    log.append([closing(log.alarm("rule-e1"), "why")])
    assert (log.alarm("rule-e1").closing.person, log.alarm("rule-e1").is_open) == (None, False)
