"""Which messages are due: each event once, again after a failure, nothing of what is muted or seen."""

from dataclasses import replace
from datetime import datetime, timedelta

import pytest

from tasks.alarms import Message, Subscription, due_messages
from tasks.alarms.deliveries import FIRST_PAUSE, LONGEST_PAUSE, MOST_TRIES, pause_after
from tests.unit.alarms.records import Log, points

MAIL = Subscription(("mail",), 0.0)


def due(log: Log, subscription: Subscription = MAIL, after: timedelta = timedelta(hours=1)) -> list[Message]:
    return due_messages(log.alarms, subscription, log.events[-1].happened_at + after)


def sent(log: Log, message: Message, action: str = "delivered", at: datetime | None = None) -> None:
    number = len(log.events)
    row = replace(message.event, event=f"{number:04d}", action=action, about=message.event.event)
    log.events.append(
        replace(
            row, target=message.target, happened_at=at or log.events[-1].happened_at + timedelta(minutes=1)
        )
    )


def told(messages: list[Message]) -> list[tuple[str, str]]:
    return [(message.event.action, message.target) for message in messages]


def raised(severity: str = "warning") -> Log:
    log = Log()
    log.evaluate(points(11.0), severity=severity)
    return log


def test_every_target_hears_of_an_alarm_once() -> None:
    log = raised()
    both = Subscription(("mail", "desk"), 0.0)
    messages = due(log, both)
    assert told(messages) == [("raised", "mail"), ("raised", "desk")]
    sent(log, messages[0])
    assert told(due(log, both)) == [("raised", "desk")]
    sent(log, messages[1])
    assert due(log, both) == []


def test_worse_and_eased_are_told_too() -> None:
    log = raised()
    sent(log, due(log)[0])
    log.evaluate(points(11.0, 20.0))
    assert told(due(log)) == [("updated", "mail")]
    sent(log, due(log)[0])
    log.evaluate(points(11.0, 20.0, 5.0))
    assert told(due(log)) == [("eased", "mail")]


def test_what_was_overtaken_is_not_sent_on_its_own() -> None:
    log = raised()
    log.evaluate(points(11.0, 20.0))
    assert told(due(log)) == [("updated", "mail")]


def test_a_failed_message_is_tried_again_after_a_pause_that_grows() -> None:
    log = raised()
    sent(log, due(log)[0], "delivery failed")
    failed_at = log.events[-1].happened_at
    assert due_messages(log.alarms, MAIL, failed_at + FIRST_PAUSE * 0.99) == []
    (again,) = due_messages(log.alarms, MAIL, failed_at + FIRST_PAUSE)
    assert again.tries == 1
    sent(log, again, "delivery failed", failed_at + FIRST_PAUSE)
    assert due_messages(log.alarms, MAIL, failed_at + FIRST_PAUSE * 2.99) == []
    assert len(due_messages(log.alarms, MAIL, failed_at + FIRST_PAUSE * 3)) == 1


def test_tries_are_bounded() -> None:
    log = raised()
    for number in range(MOST_TRIES):
        (message,) = due(log, after=LONGEST_PAUSE)
        assert message.is_last_try is (number == MOST_TRIES - 1)
        sent(log, message, "delivery failed", log.events[-1].happened_at + LONGEST_PAUSE)
    assert due(log, after=10 * LONGEST_PAUSE) == []
    log.evaluate(points(11.0, 20.0))
    assert told(due(log)) == [("updated", "mail")]


def test_pauses_double_up_to_the_longest() -> None:
    pauses = [pause_after(failures) for failures in range(1, MOST_TRIES)]
    assert pauses[:3] == [FIRST_PAUSE, 2 * FIRST_PAUSE, 4 * FIRST_PAUSE]
    assert pauses[-1] == LONGEST_PAUSE
    assert timedelta(days=2) < sum(pauses, timedelta()) < timedelta(days=4)


def test_nothing_is_sent_while_an_alarm_is_muted_and_a_reminder_when_that_is_over() -> None:
    log = raised()
    log.by_hand("rule-e1", "muted")
    assert due(log) == []
    log.by_hand("rule-e1", "unmuted")
    assert told(due(log)) == [("raised", "mail")]


def test_what_a_person_has_seen_or_closed_is_not_sent() -> None:
    for deed in ("acknowledged", "closed"):
        log = raised()
        log.by_hand("rule-e1", deed)
        assert due(log) == []


def test_an_acknowledged_alarm_that_becomes_worse_is_sent() -> None:
    log = raised()
    log.by_hand("rule-e1", "acknowledged")
    log.evaluate(points(11.0, 20.0))
    assert told(due(log)) == [("updated", "mail")]


def test_who_heard_of_an_alarm_hears_that_its_finding_is_gone() -> None:
    log = raised()
    sent(log, due(log)[0])
    log.evaluate(points(5.0))
    assert told(due(log)) == [("closed", "mail")]
    silent = raised()
    silent.evaluate(points(5.0))
    assert due(silent) == []


def test_an_alarm_that_came_and_went_is_told_while_it_is_news() -> None:
    log = Log()
    log.evaluate(points(11.0, 5.0))
    assert told(due(log)) == [("eased", "mail")]
    assert due(log, after=timedelta(days=8)) == []


@pytest.mark.parametrize(("hours", "n_due"), [(5.0, 0), (7.0, 1)])
def test_a_target_is_not_told_again_within_the_hours_of_the_rule(hours: float, n_due: int) -> None:
    rare = Subscription(("mail",), 6.0)
    log = raised()
    sent(log, due(log, rare)[0])
    log.evaluate(points(11.0, 20.0))
    assert len(due_messages(log.alarms, rare, log.events[1].happened_at + timedelta(hours=hours))) == n_due


def test_two_alarms_of_a_rule_are_one_message_within_its_hours() -> None:
    log = Log()
    log.evaluate(points(11.0, 5.0, 12.0))
    assert len(due(log)) == 2
    assert len(due(log, Subscription(("mail",), 6.0))) == 1


@pytest.mark.parametrize("back", [timedelta(minutes=30), timedelta(days=3650)])
def test_a_clock_that_was_set_back_silences_nobody(back: timedelta) -> None:
    rare = Subscription(("mail",), 6.0)
    log = raised()
    sent(log, due(log, rare)[0])
    log.evaluate(points(11.0, 20.0))
    now = log.events[-1].happened_at - back
    (message,) = due_messages(log.alarms, rare, now)
    sent(log, message, "delivery failed", now)
    assert due_messages(log.alarms, rare, now + FIRST_PAUSE * 0.5) == []
    (message,) = due_messages(log.alarms, rare, now + FIRST_PAUSE)
    sent(log, message, at=now + FIRST_PAUSE)
    log.evaluate(points(11.0, 20.0, 30.0))
    assert due_messages(log.alarms, rare, now + timedelta(hours=1)) == []
    assert len(due_messages(log.alarms, rare, now + timedelta(hours=7))) == 1


def test_a_failure_dated_ahead_is_tried_again_at_once() -> None:
    log = raised()
    sent(log, due(log)[0], "delivery failed", log.events[-1].happened_at + timedelta(days=3650))
    assert len(due_messages(log.alarms, MAIL, log.events[0].happened_at + FIRST_PAUSE)) == 1
