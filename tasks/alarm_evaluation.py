"""What is to be said about the alarms of a structure now: the record against the rules of the campaign file."""

from collections.abc import Iterator, Sequence
from datetime import datetime

from storage.alarm_log import UNNUMBERED, append_alarm_events
from storage.catalog import rebuild_catalog
from storage.locks import publish_lock
from storage.records import AlarmEventRow
from storage.views import alarm_event_rows
from storage.workspace import Workspace
from tasks.alarm_record import read_record
from tasks.alarms import (
    RULES,
    Alarm,
    PendingEpoch,
    Record,
    Rule,
    Step,
    alarms_of,
    closing,
    follow_apart,
    follow_rule,
    settle,
    unmuting,
)
from tasks.settings import Campaign
from tasks.settings.alarms import COMMON_KEYS
from tasks.settings.alarms import Alarm as AlarmRule

__all__ = ["PendingEpoch", "evaluate_alarms", "event_of", "rule_of"]


def evaluate_alarms(
    workspace: Workspace,
    campaign: Campaign,
    now: datetime,
    pending: Sequence[PendingEpoch] | None = None,
) -> list[AlarmEventRow]:
    """Hold the record against the rules and add what follows to the log of alarms.

    The same record at the same time adds nothing, whoever asks and how often: the log is read and added to under the
    publish lock. The catalog is brought up to date before and, where anything was added, after.

    Parameters
    ----------
    pending
        Epochs that have begun to arrive; None where the caller did not look, then alarms about late stations stay.

    Returns
    -------
    list of AlarmEventRow
        What was added, in the order in which it happened.

    Raises
    ------
    StorageError
        If the catalog or the log cannot be read or written.
    """
    structure = campaign.structure.id
    with publish_lock(workspace):
        rebuild_catalog(workspace)
        record = read_record(workspace, campaign, now, pending)
        known = alarm_event_rows(workspace, structure)
        steps = _steps(campaign, record, alarms_of(known))
        added = append_alarm_events(workspace, [event_of(structure, step, now) for step in steps])
        # what has eased just now may be settled at once
        settled = [step for alarm in alarms_of([*known, *added]) if (step := settle(alarm))]
        added += append_alarm_events(workspace, [event_of(structure, step, now) for step in settled])
        if added:
            rebuild_catalog(workspace)
    return added


def rule_of(table: AlarmRule) -> Rule:
    """The rule of a table of the campaign file."""
    keys = {key: value for key, value in table if key not in COMMON_KEYS}
    return RULES[table.when].rule(**keys)


def event_of(structure: str, step: Step, now: datetime) -> AlarmEventRow:
    """A step of the program as a row of the log, without its id."""
    return AlarmEventRow(
        event=UNNUMBERED,
        structure=structure,
        alarm=step.alarm,
        epoch=step.epoch,
        rule=step.rule,
        severity=step.severity,
        action=step.action,
        happened_at=now,
        value=step.value,
        limit_value=step.limit_value,
        note=step.note,
        unit=step.unit,
    )


def _steps(campaign: Campaign, record: Record, alarms: Sequence[Alarm]) -> Iterator[Step]:
    taken = frozenset(alarm.name for alarm in alarms)
    for table in campaign.alarm_rules:
        follow = follow_apart if RULES[table.when].apart else follow_rule
        own = [alarm for alarm in alarms if alarm.rule == table.id]
        steps = follow(table.id, table.severity, rule_of(table).points(record), own, taken)
        taken |= {step.alarm for step in steps}
        yield from steps
    rules = {table.id for table in campaign.alarm_rules}
    for alarm in alarms:
        if not alarm.is_open:
            continue
        if alarm.rule not in rules:
            yield closing(alarm, f"the campaign file has no rule {alarm.rule} any more")
        elif alarm.mute is not None and not alarm.is_muted(record.now):
            yield unmuting(alarm)
