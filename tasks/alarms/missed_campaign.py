"""No measurement for too long."""

from collections.abc import Sequence
from dataclasses import dataclass

from tasks.alarms.model import Finding, Point, RuleKind
from tasks.alarms.record import Record


@dataclass(frozen=True, slots=True, kw_only=True)
class MissedCampaignRule:
    """Broken where no epoch was measured for longer than ``interval_days`` and ``grace_days``.

    An epoch that failed counts as none. It eases with the next epoch.
    """

    interval_days: float
    grace_days: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge the present by the clock; before the first epoch nothing is told."""
        measured = [epoch for epoch in record.epochs if epoch.state != "failed"]
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
            what=f"the newest epoch, {newest.epoch}, was measured {days:.1f} days ago; allowed are"
            f" {self.interval_days:g} days and {self.grace_days:g} of grace",
        )
        return [Point(newest.epoch, None, finding, by_clock=True)]


KIND = RuleKind(
    name="missed-campaign",
    description="no epoch for longer than the interval of the campaigns",
    advice="Was nothing measured, or has it not arrived, or was it not processed? Look into the inbox and at "
    "tiltwatch status.",
    rule=MissedCampaignRule,
)
