"""No measurement for too long."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import timedelta
from typing import Final

from tasks.alarms.model import Finding, Point, RuleKind
from tasks.alarms.record import Record

AHEAD: Final = timedelta(days=1)
"""So far ahead of the clock may an epoch be dated: two clocks differ, or a time zone was mistaken."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MissedCampaignRule:
    """Broken where no epoch was measured for longer than ``interval_days`` and ``grace_days``.

    An epoch that failed counts as none, and so does one that is dated more than a day ahead of the clock: its date, or
    the clock, is wrong, and it would keep the rule quiet for as long. It eases with the next epoch.
    """

    interval_days: float
    grace_days: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge the present by the clock; before the first epoch nothing is told."""
        latest = record.now + AHEAD
        measured = [epoch for epoch in record.epochs if epoch.state != "failed" and epoch.time <= latest]
        if not measured:
            return []
        newest = max(measured, key=lambda epoch: epoch.time)
        days = (record.now - newest.time).total_seconds() / 86400.0
        allowed = self.interval_days + self.grace_days
        finding = Finding(
            value=days,
            limit_value=allowed,
            unit="d",
            broken=days > allowed,
            eased=days <= allowed,
            what=f"the newest epoch, {newest.epoch}, {_measured(days)}; allowed are"
            f" {self.interval_days:g} days and {self.grace_days:g} of grace",
        )
        return [Point(newest.epoch, None, finding, by_clock=True)]


def _measured(days: float) -> str:
    return f"was measured {days:.1f} days ago" if days >= 0.0 else "is dated ahead of this machine's clock"


KIND = RuleKind(
    name="missed-campaign",
    description="no epoch for longer than the interval of the campaigns",
    advice="Was nothing measured, or has it not arrived, or was it not processed? Look into the inbox and at "
    "tiltwatch status.",
    rule=MissedCampaignRule,
)
