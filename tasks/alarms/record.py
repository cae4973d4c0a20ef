"""What rules of alarms look at: the record of a structure under its primary scheme and method, in plain values."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation:
    """The deviation of an epoch against its limit; metres."""

    deviation_m: float
    sigma_m: float | None
    allowable_m: float | None
    verdict: str
    """pass, fail, cannot tell or no limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """One quantity of an epoch against the reference epoch, with its test."""

    size_m: float
    sigma_m: float | None
    statistic: float | None
    freedom: int | None
    p_value: float | None
    east: float | None
    """East of the change in its own unit; None where it has no direction."""
    north: float | None
    reference_epoch: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartPoint:
    """An epoch in the control chart."""

    cusum: float
    watch_limit: float
    alarm_limit: float


@dataclass(frozen=True, slots=True, kw_only=True)
class EpochState:
    """What is known of an epoch."""

    epoch: str
    time: datetime
    state: str
    """ok, degraded or failed."""
    reason: str | None
    n_stations_used: int
    coverage_deg: float | None
    deviation: Deviation | None
    """None where the primary gave no axis."""
    changes: Mapping[str, Change] = field(default_factory=dict)
    """Change by quantity: lean, base, bending, radius, centres."""
    control_changes: Mapping[str, Change] = field(default_factory=dict)
    """The same as the control of the campaign has it, as far as it has."""
    chart: ChartPoint | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Trend:
    """The trend over all epochs up to ``last_epoch``; None where it cannot be told."""

    last_epoch: str
    last_time: datetime
    rate_m_per_year: float | None
    rate_sigma_m_per_year: float | None
    rate_significant: bool | None
    limit_reached_at: datetime | None
    limit_earliest_at: datetime | None


@dataclass(frozen=True, slots=True, kw_only=True)
class PendingEpoch:
    """An epoch that has begun to arrive and is not processed yet; a watch of an inbox knows of it."""

    epoch: str
    first_arrival: datetime
    """When its first station arrived."""
    missing: tuple[str, ...]
    """Stations that have not arrived; none where only the processing is still to come."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """All that rules look at."""

    epochs: tuple[EpochState, ...]
    """Stored epochs, the earliest first."""
    trend: Trend | None
    now: datetime
    pending: tuple[PendingEpoch, ...] | None = None
    """None where nobody has looked what is still to come."""
