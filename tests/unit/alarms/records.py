"""A record of a structure in plain values, and a log that is filled as the program fills it."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta

from storage.records import AlarmEventRow
from tasks.alarms import (
    Alarm,
    Change,
    ChartPoint,
    Deviation,
    EpochState,
    Finding,
    PendingEpoch,
    Point,
    Record,
    Step,
    Trend,
    alarms_of,
    follow_rule,
    settle,
)

START = datetime(2025, 1, 1, 6, 0, tzinfo=UTC)


def time_of(number: int) -> datetime:
    """An epoch a year."""
    return START + timedelta(days=365 * number)


def epoch(number: int, **known: object) -> EpochState:
    plain = EpochState(
        epoch=f"e{number}",
        time=time_of(number),
        state="ok",
        reason=None,
        n_stations_used=8,
        coverage_deg=360.0,
        deviation=Deviation(deviation_m=0.01, sigma_m=0.001, allowable_m=None, verdict="no limit"),
    )
    return replace(plain, **known)


def deviation(metres: float, sigma_m: float | None = 0.002, verdict: str = "pass") -> Deviation:
    """Against a limit of 100 mm."""
    return Deviation(deviation_m=metres, sigma_m=sigma_m, allowable_m=0.1, verdict=verdict)


def change(
    size_m: float, p_value: float, statistic: float, towards: tuple[float, float] = (1.0, 0.0)
) -> Change:
    return Change(
        size_m=size_m,
        sigma_m=0.002,
        statistic=statistic,
        freedom=2,
        p_value=p_value,
        east=towards[0] * size_m,
        north=towards[1] * size_m,
        reference_epoch="e0",
    )


def trend(**known: object) -> Trend:
    plain = Trend(
        last_epoch="e5",
        last_time=time_of(5),
        rate_m_per_year=0.006,
        rate_sigma_m_per_year=0.0005,
        rate_significant=True,
        limit_reached_at=time_of(10),
        limit_earliest_at=time_of(8),
    )
    return replace(plain, **known)


def record(
    *epochs: EpochState,
    now: datetime | None = None,
    pending: tuple[PendingEpoch, ...] | None = None,
    rates: Trend | None = None,
) -> Record:
    return Record(epochs=epochs, trend=rates, now=now or time_of(20), pending=pending)


def chart(cusum: float) -> ChartPoint:
    return ChartPoint(cusum=cusum, watch_limit=4.0, alarm_limit=5.0)


def finding(value: float, limit: float = 10.0) -> Finding:
    """Broken above 10, eased below 9."""
    return Finding(
        value=value,
        limit_value=limit,
        unit="m",
        broken=value > limit,
        eased=value < 0.9 * limit,
        what=f"{value:g}",
    )


def points(*values: float | None, first: int = 1) -> list[Point]:
    """A value an epoch, e1 first; None where nothing can be told."""
    return [
        Point(f"e{n}", f"e{n}", None if value is None else finding(value))
        for n, value in enumerate(values, start=first)
    ]


class Log:
    """A log of one structure, evaluated again and again as the program does."""

    def __init__(self) -> None:
        self.events: list[AlarmEventRow] = []

    def evaluate(self, points: Sequence[Point], severity: str = "warning", rule: str = "rule") -> list[str]:
        """Follow the rule; returns what was added, as ``action alarm``."""
        own = [alarm for alarm in self.alarms if alarm.rule == rule]
        taken = frozenset(alarm.name for alarm in self.alarms)
        before = len(self.events)
        self.append(follow_rule(rule, severity, points, own, taken))
        self.append([step for alarm in self.alarms if (step := settle(alarm))])
        return [f"{event.action} {event.alarm}" for event in self.events[before:]]

    def append(self, steps: Sequence[Step]) -> None:
        for step in steps:
            facts = {name: getattr(step, name) for name in step.__slots__}
            self.events.append(AlarmEventRow(**self._stamp(), structure="pole", **facts))

    def by_hand(self, alarm: str, action: str, epoch: str | None = None, **said: object) -> None:
        """A deed of a person; a closing carries the newest epoch."""
        found = next(one for one in self.alarms if one.name == alarm).found
        event = replace(found, **self._stamp(), action=action, person="Ann", note="seen", **said)
        self.events.append(event if epoch is None else replace(event, epoch=epoch))

    @property
    def alarms(self) -> list[Alarm]:
        return alarms_of(self.events)

    def alarm(self, name: str) -> Alarm:
        return next(alarm for alarm in self.alarms if alarm.name == name)

    def _stamp(self) -> dict[str, object]:
        number = len(self.events)
        return {"event": f"{number:04d}", "happened_at": START + timedelta(minutes=number)}
