"""Small changes that add up: the control chart."""

from collections.abc import Sequence
from dataclasses import dataclass

from tasks.alarms.model import Finding, Point, RuleKind
from tasks.alarms.record import ChartPoint, Record


@dataclass(frozen=True, slots=True, kw_only=True)
class CusumRule:
    """Broken from the watch or the alarm limit of the chart on."""

    signal: str
    clear_ratio: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge every epoch in the chart."""
        return [Point(epoch.epoch, epoch.epoch, self._finding(epoch.chart)) for epoch in record.epochs]

    def _finding(self, chart: ChartPoint | None) -> Finding | None:
        if chart is None:
            return None
        limit = chart.alarm_limit if self.signal == "alarm" else chart.watch_limit
        return Finding(
            value=chart.cusum,
            limit_value=limit,
            unit="1",
            broken=chart.cusum >= limit,
            eased=chart.cusum < self.clear_ratio * limit,
            what=f"the CUSUM of the lean is {chart.cusum:.2f}, its {self.signal} limit {limit:.2f}",
        )


KIND = RuleKind(
    name="cusum",
    description="small changes against all earlier epochs add up",
    advice="Look at the control chart and the trend: since when does it drift, and into which direction?",
    rule=CusumRule,
)
