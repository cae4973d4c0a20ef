"""The deviation against the allowable one, by the guard band of its verdict."""

from collections.abc import Sequence
from dataclasses import dataclass

from tasks.alarms.model import GUARD_SIGMAS, Finding, Point, RuleKind, millimetres
from tasks.alarms.record import Deviation, Record


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitRule:
    """Broken where the verdict is ``fail``, or ``cannot tell`` where that is asked for.

    It eases when the end of the guard band that broke it is back below ``clear_ratio`` times the limit.
    """

    at_least: str
    clear_ratio: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge every epoch that has a limit."""
        return [Point(epoch.epoch, epoch.epoch, self._finding(epoch.deviation)) for epoch in record.epochs]

    def _finding(self, found: Deviation | None) -> Finding | None:
        if found is None or found.allowable_m is None:
            return None
        guard_m = None if found.sigma_m is None else GUARD_SIGMAS * found.sigma_m
        broken = found.verdict in ("fail", self.at_least)
        side = 1.0 if self.at_least == "cannot tell" else -1.0
        eased = guard_m is not None and (
            found.deviation_m + side * guard_m < self.clear_ratio * found.allowable_m
        )
        around = " of unknown uncertainty" if guard_m is None else f" ± {millimetres(guard_m)} (k=2)"
        return Finding(
            value=found.deviation_m,
            limit_value=found.allowable_m,
            unit="m",
            broken=broken,
            eased=eased and not broken,
            what=f"the deviation is {millimetres(found.deviation_m)}{around}, the allowable one"
            f" {millimetres(found.allowable_m)}: verdict {found.verdict}",
        )


KIND = RuleKind(
    name="limit",
    description="the deviation is beyond the allowable one, by the guard band of the verdict",
    advice="Check that the epoch is sound (tiltwatch status), have the deviation confirmed by a second measurement, "
    "and let the engineer in charge of the structure decide about its use.",
    rule=LimitRule,
)
