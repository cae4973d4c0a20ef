"""Data that are not good enough."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from tasks.alarms.model import Finding, Point, RuleKind, millimetres
from tasks.alarms.record import EpochState, Record

GRADES: Final = {"ok": 0.0, "degraded": 1.0, "failed": 2.0}
"""State of an epoch as a number, so that a worse one is larger."""


@dataclass(frozen=True, slots=True, kw_only=True)
class QualityRule:
    """Broken where one thing about the data is worse than allowed; exactly one of the four is not None.

    ``clear_ratio`` belongs to sigma and coverage; a state and a number of stations ease as soon as they are right.
    """

    state: str | None
    sigma_mm: float | None
    coverage_deg: float | None
    stations: int | None
    clear_ratio: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge every epoch."""
        return [Point(epoch.epoch, epoch.epoch, self._finding(epoch)) for epoch in record.epochs]

    def _finding(self, epoch: EpochState) -> Finding | None:
        if self.state is not None:
            return _state(epoch, self.state)
        if self.sigma_mm is not None:
            return self._sigma(epoch, self.sigma_mm / 1e3)
        if self.coverage_deg is not None:
            return self._coverage(epoch, self.coverage_deg)
        return None if self.stations is None else _stations(epoch, self.stations)

    def _sigma(self, epoch: EpochState, most_m: float) -> Finding | None:
        if epoch.deviation is None or epoch.deviation.sigma_m is None:
            return None
        sigma_m = epoch.deviation.sigma_m
        return Finding(
            value=sigma_m,
            limit_value=most_m,
            unit="m",
            broken=sigma_m > most_m,
            eased=sigma_m < self.clear_ratio * most_m,
            what=f"the deviation has a standard deviation of {millimetres(sigma_m)}, allowed are {millimetres(most_m)}",
        )

    def _coverage(self, epoch: EpochState, least_deg: float) -> Finding | None:
        if epoch.coverage_deg is None:
            return None
        return Finding(
            value=epoch.coverage_deg,
            limit_value=least_deg,
            unit="deg",
            broken=epoch.coverage_deg < least_deg,
            eased=epoch.coverage_deg >= min(least_deg / self.clear_ratio, 360.0),
            what=f"{epoch.coverage_deg:.0f}° of the circumference were seen, needed are {least_deg:g}°",
            falls=True,
        )


def _state(epoch: EpochState, worst: str) -> Finding:
    without_axis = epoch.deviation is None
    grade = GRADES["failed"] if without_axis else GRADES[epoch.state]
    because = f": {epoch.reason}" if epoch.reason else ""
    told = f"the epoch is {epoch.state}{because}"
    if without_axis and epoch.state != "failed":
        told = f"the primary scheme gave no axis{because}"
    return Finding(
        value=grade,
        limit_value=GRADES[worst],
        unit="1",
        broken=grade >= GRADES[worst],
        eased=grade < GRADES[worst],
        what=told,
    )


def _stations(epoch: EpochState, least: int) -> Finding:
    return Finding(
        value=float(epoch.n_stations_used),
        limit_value=float(least),
        unit="1",
        broken=epoch.n_stations_used < least,
        eased=epoch.n_stations_used >= least,
        what=f"{epoch.n_stations_used} stations entered the result, needed are {least}",
        falls=True,
    )


KIND = RuleKind(
    name="quality",
    description="the data of an epoch are not good enough",
    advice="Look at the stations and the coverage of the epoch; measure again what is missing while nothing has moved.",
    rule=QualityRule,
)
