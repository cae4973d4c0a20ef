"""How fast the structure moves, or how soon it reaches its limit if it goes on like that."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from tasks.alarms.model import GUARD_SIGMAS, Finding, Point, RuleKind
from tasks.alarms.record import Record, Trend

DAYS_PER_YEAR: Final = 365.25

HORIZON_YEARS: Final = 100.0
"""As far as trends are extrapolated; a limit that is not reached until then is stated as that far away."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RateRule:
    """Broken where the rate is above ``mm_per_year`` by more than its guard band, or the limit too near.

    Too near: the rate is significant, and the upper 95 % bound of the deviation reaches the limit within
    ``limit_within_years`` after the last epoch. Only the newest epoch is judged: there is one trend over all epochs.
    """

    mm_per_year: float | None
    limit_within_years: float | None
    clear_ratio: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge the last epoch of the trend; of the epochs before it nothing is told."""
        trend = record.trend
        if trend is None:
            return []
        return [
            Point(epoch.epoch, epoch.epoch, self._finding(trend) if epoch.epoch == trend.last_epoch else None)
            for epoch in record.epochs
        ]

    def _finding(self, trend: Trend) -> Finding | None:
        if self.mm_per_year is not None:
            return self._speed(trend, self.mm_per_year / 1e3)
        return None if self.limit_within_years is None else self._nearness(trend, self.limit_within_years)

    def _speed(self, trend: Trend, limit_m_per_year: float) -> Finding | None:
        rate, sigma = trend.rate_m_per_year, trend.rate_sigma_m_per_year
        if rate is None or sigma is None:
            return None
        surely = rate - GUARD_SIGMAS * sigma
        return Finding(
            value=rate,
            limit_value=limit_m_per_year,
            unit="m/a",
            broken=surely > limit_m_per_year,
            eased=surely < self.clear_ratio * limit_m_per_year,
            what=f"the top moves by {1e3 * rate:.2f} ± {2e3 * sigma:.2f} mm a year (k=2);"
            f" allowed are {1e3 * limit_m_per_year:g} mm a year",
        )

    def _nearness(self, trend: Trend, limit_years: float) -> Finding | None:
        if trend.rate_m_per_year is None or trend.rate_significant is None:
            return None
        reached = trend.limit_earliest_at if trend.rate_significant else None
        years = HORIZON_YEARS
        told = "at this rate the limit is not reached within 100 years"
        if not trend.rate_significant:
            told = "no significant rate leads to the limit"
        elif reached is not None:
            years = max((reached - trend.last_time).total_seconds() / 86400.0 / DAYS_PER_YEAR, 0.0)
            told = f"the limit may be reached as early as {reached:%Y-%m-%d}, {years:.1f} years after the last epoch"
        return Finding(
            value=years,
            limit_value=limit_years,
            unit="a",
            broken=years < limit_years,
            eased=years > limit_years / self.clear_ratio,
            what=f"{told}; needed are {limit_years:g} years",
            falls=True,
        )


KIND = RuleKind(
    name="rate",
    description="the structure moves too fast, or will reach its limit too soon",
    advice="Look at the trend with its change points; shorten the interval of the campaigns, and let the engineer in "
    "charge of the structure know the date at which the limit is reached.",
    rule=RateRule,
)
