"""Alarms reach people: what the record says is put into the log, and what is in the log is sent out."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

from flows.alarm_events import tell_prefect
from flows.alarm_targets import Letter, send
from flows.alarm_text import body_of, facts_of_event, title_of
from flows.prefect_home import take_home, users_server
from storage.alarm_log import UNNUMBERED, append_alarm_events
from storage.catalog import rebuild_catalog
from storage.locks import delivery_lock
from storage.records import AlarmEventRow
from storage.views import alarm_event_rows, epoch_rows
from storage.workspace import Workspace
from tasks.alarm_evaluation import PendingEpoch, evaluate_alarms
from tasks.alarms import Message, Subscription, alarms_of, due_messages
from tasks.settings import Campaign
from tasks.settings.alarms import Alarm as AlarmRule

__all__ = ["Alarmed", "PendingEpoch", "deliver_alarms", "evaluate_and_deliver"]


@dataclass(frozen=True, slots=True)
class Alarmed:
    """What was added to the log of alarms."""

    events: tuple[AlarmEventRow, ...]
    """What happened to alarms."""
    sent: tuple[AlarmEventRow, ...]
    """Deliveries, failed ones too."""

    @property
    def failures(self) -> tuple[str, ...]:
        """Why messages could not be delivered."""
        return tuple(
            f"{row.alarm} to {row.target}: {row.note}" for row in self.sent if row.action != "delivered"
        )


def evaluate_and_deliver(
    workspace: Workspace,
    campaign: Campaign,
    now: datetime,
    pending: Sequence[PendingEpoch] | None = None,
) -> Alarmed:
    """Hold the record against the rules, tell Prefect where there is a server, and send what is due.

    To be called after every run, and now and then without one (``tiltwatch alarms FILE --evaluate``, the ticks of a
    watch): only the clock finds a campaign that was missed, and a message that failed is tried again.

    Parameters
    ----------
    pending
        Epochs that have begun to arrive; None where the caller did not look.

    Raises
    ------
    StorageError
        If the catalog or the log cannot be read or written.
    """
    events = evaluate_alarms(workspace, campaign, now, pending)
    if events and users_server() is not None:
        take_home(workspace)
    tell_prefect(events)
    return Alarmed(tuple(events), tuple(deliver_alarms(workspace, campaign, now)))


def deliver_alarms(workspace: Workspace, campaign: Campaign, now: datetime) -> list[AlarmEventRow]:
    """Send what no target has heard yet, and put down what became of it; a failed message waits for its next try.

    A crash between a message and its line in the log sends it twice: rather that than never.

    Raises
    ------
    StorageError
        If the catalog or the log cannot be read or written, or another process sends for minutes on end.
    """
    if not campaign.notify:
        return []
    structure = campaign.structure.id
    sent: list[AlarmEventRow] = []
    with delivery_lock(workspace, structure):
        rebuild_catalog(workspace)
        unreachable: set[str] = set()
        for rule, message in _due(campaign, alarm_event_rows(workspace, structure), now):
            if message.target in unreachable:
                continue  # it stays due: one that does not answer must not cost its time limit for each of many
            row = _outcome(workspace, campaign, rule, message, now)
            sent += append_alarm_events(workspace, [row])
            if row.action != "delivered":
                unreachable.add(message.target)
        if sent:
            rebuild_catalog(workspace)
    return sent


def _due(
    campaign: Campaign, events: Sequence[AlarmEventRow], now: datetime
) -> Iterator[tuple[AlarmRule, Message]]:
    alarms = alarms_of(events)
    for rule in campaign.alarm_rules:
        own = [alarm for alarm in alarms if alarm.rule == rule.id]
        for message in due_messages(own, Subscription(rule.notify, rule.mute_hours_between), now):
            yield rule, message


def _outcome(
    workspace: Workspace, campaign: Campaign, rule: AlarmRule, message: Message, now: datetime
) -> AlarmEventRow:
    """Send a message; the event says what became of it."""
    event = message.event
    target = next(target for target in campaign.notify if target.id == message.target)
    epochs = {row.epoch: row for row in epoch_rows(workspace, campaign.structure.id)}
    letter = Letter(
        title=title_of(campaign, event),
        body=body_of(campaign, rule, message, epochs.get(event.epoch or "")),
        severity=event.severity,
        is_over=event.action in ("eased", "closed"),
        facts=facts_of_event(campaign, rule, event),
    )
    reason = send(target, letter, campaign.folder)
    if reason is not None and message.is_last_try:
        reason += f"; given up after {message.tries + 1} tries"
    return replace(
        event,
        event=UNNUMBERED,
        action="delivered" if reason is None else "delivery failed",
        happened_at=now,
        person=None,
        note=reason,
        until=None,
        about=event.event,
        target=target.id,
    )
