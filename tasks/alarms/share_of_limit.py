"""The deviation against a share of the allowable one: a warning ahead of the limit."""

from collections.abc import Sequence
from dataclasses import dataclass

from tasks.alarms.model import GUARD_SIGMAS, Finding, Point, RuleKind, millimetres
from tasks.alarms.record import Deviation, Record


@dataclass(frozen=True, slots=True, kw_only=True)
class ShareOfLimitRule:
    """Broken where the deviation itself, without a guard band, is above ``share`` of the allowable one."""

    share: float
    clear_ratio: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge every epoch that has a limit."""
        return [Point(epoch.epoch, epoch.epoch, self._finding(epoch.deviation)) for epoch in record.epochs]

    def _finding(self, found: Deviation | None) -> Finding | None:
        if found is None or found.allowable_m is None:
            return None
        threshold_m = self.share * found.allowable_m
        around = (
            " of unknown uncertainty"
            if found.sigma_m is None
            else f" ± {millimetres(GUARD_SIGMAS * found.sigma_m)} (k=2)"
        )
        return Finding(
            value=found.deviation_m,
            limit_value=threshold_m,
            unit="m",
            broken=found.deviation_m > threshold_m,
            eased=found.deviation_m < self.clear_ratio * threshold_m,
            what=f"the deviation is {millimetres(found.deviation_m)}{around}, {100.0 * self.share:g} % of the allowable"
            f" one {millimetres(threshold_m)}",
        )


KIND = RuleKind(
    name="share-of-limit",
    description="the deviation is above a share of the allowable one",
    advice="Measure more often, and look at the trend: when will the limit be reached?",
    rule=ShareOfLimitRule,
)
