"""What happens to the alarms of a rule: raised, updated, eased, closed; the record and the log decide, no memory.

The same record and the same log always give the same answer, and what was appended is not asked for again: a crash
between two events, or a second process, changes nothing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from storage.records import AlarmEventRow
from tasks.alarms.history import Alarm
from tasks.alarms.model import SEVERITIES, Finding, Point

NOTABLE: Final = 1.2
"""A value that has become worse by this factor since it was told last is told again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """Something that happens to an alarm, without the time and the structure."""

    alarm: str
    rule: str
    action: str
    epoch: str | None
    severity: str
    value: float
    limit_value: float
    unit: str | None
    note: str | None


@dataclass(frozen=True, slots=True)
class Followed:
    """What an alarm went through, and the place in the points from which on a new one may begin; None while it lasts."""

    steps: tuple[Step, ...]
    next_begins: int | None


def follow_rule(
    rule: str, severity: str, points: Sequence[Point], alarms: Sequence[Alarm], taken: frozenset[str]
) -> list[Step]:
    """What the points of a rule make of its alarms.

    An active alarm is not raised again. A closed one is raised anew only by a point after it was closed, or after the
    rule had eased; what lies before that was dealt with.

    Parameters
    ----------
    rule, severity
        Id and severity of the rule.
    points
        What the rule finds, the earliest first.
    alarms
        Alarms of the rule in the log.
    taken
        Ids of all alarms in the log.
    """
    steps: list[Step] = []
    begins = [_dealt_with(points, alarm) for alarm in alarms if not alarm.is_active]
    lasts = False
    for alarm in (alarm for alarm in alarms if alarm.is_active):
        followed = _follow(alarm, severity, points)
        steps.extend(followed.steps)
        lasts = lasts or followed.next_begins is None
        begins.append(followed.next_begins or 0)
    if not lasts:
        steps.extend(_new_alarms(rule, severity, points[max(begins, default=0) :], taken))
    return steps


def follow_apart(
    rule: str, severity: str, points: Sequence[Point], alarms: Sequence[Alarm], taken: frozenset[str]
) -> list[Step]:
    """The same for a rule whose points stand each for itself."""
    steps: list[Step] = []
    for point in points:
        own = [alarm for alarm in alarms if alarm.raised.epoch == point.epoch]
        steps.extend(follow_rule(rule, severity, [point], own, taken))
    return steps


def settle(alarm: Alarm) -> Step | None:
    """Close an alarm that has eased and that nobody has to see any more: acknowledged, or information only."""
    if not alarm.is_open or not alarm.is_eased:
        return None
    if alarm.is_acknowledged:
        return closing(alarm, "eased, and acknowledged")
    if alarm.found.severity == SEVERITIES[0]:
        return closing(alarm, "eased; information needs no acknowledgement")
    return None


def unmuting(alarm: Alarm) -> Step:
    """End a mute whose time is over."""
    return replace(_step_of(alarm.found), action="unmuted", note="the time of the mute is over")


def closing(alarm: Alarm, note: str) -> Step:
    """Close an alarm by the program."""
    return replace(_step_of(alarm.found), action="closed", note=note)


def _follow(alarm: Alarm, severity: str, points: Sequence[Point]) -> Followed:
    """Go on with an active alarm from the point that it stated last."""
    places = [point.place for point in points]
    first = _place(places, alarm.raised.epoch)
    last = _place(places, alarm.found.epoch)
    if gone := _gone(alarm, points, first, last):
        return Followed((closing(alarm, gone),), 0 if first is None else first)
    told = _step_of(alarm.found)
    steps: list[Step] = []
    for place in range(last or 0, len(points)):
        finding = points[place].finding
        if finding is None:
            continue
        if finding.eased:
            steps.append(_found(told, "eased", points[place], finding, severity))
            return Followed(tuple(steps), place)
        if finding.broken and _is_notable(finding, told.value):
            told = _found(told, "updated", points[place], finding, severity)
            steps.append(told)
    if SEVERITIES.index(severity) > SEVERITIES.index(told.severity):
        steps.append(
            replace(
                told, action="updated", severity=severity, note=f"{told.note}; now of severity {severity}"
            )
        )
    return Followed(tuple(steps), None)


def _gone(alarm: Alarm, points: Sequence[Point], first: int | None, last: int | None) -> str | None:
    """Why nothing is left of what an alarm was raised for; None where something is."""
    if not points or points[-1].by_clock:
        return None
    if first is None and last is None:
        return f"the finding is gone: epoch {alarm.found.epoch} is not stored any more"
    low, high = (last if first is None else first), (first if last is None else last)
    findings = [point.finding for point in points[low : (high or 0) + 1] if point.finding is not None]
    if findings and all(finding.eased for finding in findings):
        return (
            f"the finding is gone: since {alarm.found.epoch} was computed anew, or the rule changed,"
            f" {findings[-1].what}"
        )
    return None


def _new_alarms(rule: str, severity: str, points: Sequence[Point], taken: frozenset[str]) -> Iterator[Step]:
    told: Step | None = None
    for point in points:
        finding = point.finding
        if finding is None:
            continue
        if told is None:
            if finding.broken:
                name = _free_name(f"{rule}-{point.place}", taken)
                taken = taken | {name}
                told = _raised(name, rule, severity, point, finding)
                yield told
        elif finding.eased:
            yield _found(told, "eased", point, finding, severity)
            told = None
        elif finding.broken and _is_notable(finding, told.value):
            told = _found(told, "updated", point, finding, severity)
            yield told


def _dealt_with(points: Sequence[Point], alarm: Alarm) -> int:
    """Place of the first point that an alarm which does not last any more leaves to a new one."""
    places = [point.place for point in points]
    ended = alarm.closing
    if alarm.is_eased:
        eased_at = _place(places, alarm.found.epoch)
        return 0 if eased_at is None else eased_at
    if ended is None or ended.person is None:
        return 0
    known = [_place(places, epoch) for epoch in (ended.epoch, *(event.epoch for event in alarm.events))]
    return max((place + 1 for place in known if place is not None), default=0)


def _place(places: Sequence[str], epoch: str | None) -> int | None:
    return places.index(epoch) if epoch in places else None


def _is_notable(finding: Finding, told: float) -> bool:
    if finding.falls:
        return finding.value < told / NOTABLE
    return finding.value > told * NOTABLE


def _free_name(wanted: str, taken: frozenset[str]) -> str:
    if wanted not in taken:
        return wanted
    number = 2
    while f"{wanted}-{number}" in taken:
        number += 1
    return f"{wanted}-{number}"


def _raised(name: str, rule: str, severity: str, point: Point, finding: Finding) -> Step:
    return Step(
        alarm=name,
        rule=rule,
        action="raised",
        epoch=point.epoch,
        severity=severity,
        value=finding.value,
        limit_value=finding.limit_value,
        unit=finding.unit,
        note=finding.what,
    )


def _found(told: Step, action: str, point: Point, finding: Finding, severity: str) -> Step:
    return replace(_raised(told.alarm, told.rule, severity, point, finding), action=action)


def _step_of(event: AlarmEventRow) -> Step:
    return Step(
        alarm=event.alarm,
        rule=event.rule,
        action=event.action,
        epoch=event.epoch,
        severity=event.severity,
        value=event.value,
        limit_value=event.limit_value,
        unit=event.unit,
        note=event.note,
    )
