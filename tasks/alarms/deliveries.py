"""Which messages are to be sent now: the log decides, so that nothing is sent twice and nothing forgotten."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

from storage.records import AlarmEventRow
from tasks.alarms.history import Alarm

MOST_TRIES: Final = 20
"""After so many failures an event is given up: with the pauses below that is about three days."""

FIRST_PAUSE: Final = timedelta(minutes=1)
LONGEST_PAUSE: Final = timedelta(hours=6)
"""After a failure, and doubled after each further one, up to the longest."""

NEWS_FOR: Final = timedelta(days=7)
"""So long is the end of an alarm news to somebody who never heard of it."""


@dataclass(frozen=True, slots=True)
class Subscription:
    """Who is told of a rule, and how often at most."""

    targets: tuple[str, ...]
    hours_between: float


@dataclass(frozen=True, slots=True)
class Message:
    """An event of an alarm that a target has not heard of."""

    alarm: Alarm
    event: AlarmEventRow
    target: str
    tries: int
    """How often it was tried before."""

    @property
    def is_last_try(self) -> bool:
        """Whether it is given up when it fails again."""
        return self.tries + 1 >= MOST_TRIES


def due_messages(alarms: Sequence[Alarm], subscription: Subscription, now: datetime) -> list[Message]:
    """Messages about the alarms of one rule that are to be sent now, the earliest alarm first.

    Of an alarm the newest event is told, with the state that it is in; what it overtook is not sent on its own. A
    target hears of a rule at most once in ``hours_between``: what comes in between is told afterwards, if it still is
    the newest.
    """
    messages = []
    heard = {target: _last_heard(alarms, target) for target in subscription.targets}
    for alarm in alarms:
        news = news_of(alarm, now)
        if news is None:
            continue
        for target in subscription.targets:
            last, pause = heard[target], timedelta(hours=subscription.hours_between)
            if last is not None and _is_within(last, pause, now):
                continue
            message = _message(alarm, news, target, now)
            if message is not None:
                messages.append(message)
                heard[target] = now
    return messages


def news_of(alarm: Alarm, now: datetime) -> AlarmEventRow | None:
    """The newest event of an alarm that is worth a message; None while it is muted or where a person has seen it."""
    ended = alarm.closing
    if alarm.is_muted(now) or (ended is not None and ended.person is not None):
        return None
    worth = [event for event in alarm.events if _is_worth_telling(alarm, event)]
    newest = worth[-1]
    seen = [e for e in alarm.events[alarm.events.index(newest) :] if e.action == "acknowledged"]
    return None if seen else newest


def _is_worth_telling(alarm: Alarm, event: AlarmEventRow) -> bool:
    if event.action in ("raised", "updated", "eased"):
        return True
    if event.action == "unmuted":
        return event.person is None and alarm.is_active
    return event.action == "closed" and not alarm.is_eased


def _message(alarm: Alarm, news: AlarmEventRow, target: str, now: datetime) -> Message | None:
    sent = [event for event in alarm.sent if event.target == target]
    if any(event.action == "delivered" and event.about == news.event for event in sent):
        return None
    heard_of_it = any(event.action == "delivered" for event in sent)
    if not heard_of_it and _is_over(news) and (news.action == "closed" or now - news.happened_at > NEWS_FOR):
        return None
    failures = [e.happened_at for e in sent if e.action == "delivery failed" and e.about == news.event]
    if len(failures) >= MOST_TRIES or (
        failures and _is_within(failures[-1], pause_after(len(failures)), now)
    ):
        return None
    return Message(alarm, news, target, len(failures))


def _is_within(then: datetime, pause: timedelta, now: datetime) -> bool:
    """Whether a pause that began then still lasts; not one that begins ahead of the clock, which was set back since.

    Rather a message too many than silence until the clock has caught up, which may take years.
    """
    return then <= now < then + pause


def pause_after(failures: int) -> timedelta:
    """How long to wait after so many failures."""
    doublings: int = 2 ** (min(failures, MOST_TRIES) - 1)
    return min(FIRST_PAUSE * doublings, LONGEST_PAUSE)


def _is_over(news: AlarmEventRow) -> bool:
    return news.action in ("eased", "closed")


def _last_heard(alarms: Sequence[Alarm], target: str) -> datetime | None:
    """When a target was told of a rule last: in the order of the log, which a clock that was set back does not turn."""
    heard = [(event.event, event.happened_at) for event in _deliveries(alarms, target)]
    return max(heard)[1] if heard else None


def _deliveries(alarms: Sequence[Alarm], target: str) -> Iterator[AlarmEventRow]:
    for alarm in alarms:
        for event in alarm.sent:
            if event.target == target and event.action == "delivered":
                yield event
