"""A station that does not arrive while its epoch has begun."""

from collections.abc import Sequence
from dataclasses import dataclass

from tasks.alarms.model import Finding, Point, RuleKind
from tasks.alarms.record import PendingEpoch, Record


@dataclass(frozen=True, slots=True, kw_only=True)
class LateStationRule:
    """Broken where stations of an epoch are missing longer than ``hours`` after its first one arrived.

    It eases when all have arrived, or the epoch was processed without them. Where that arrival lies further ahead of the
    clock than ``hours``, one of the two times is wrong and nobody knows how long it was: it is broken then.
    """

    hours: float

    def points(self, record: Record) -> Sequence[Point]:
        """Judge every epoch by itself, those that are to come by the clock; nothing where nobody looked for them."""
        pending = {epoch.epoch: epoch for epoch in record.pending or ()}
        stored = [
            Point(epoch.epoch, epoch.epoch, self._arrived("the epoch was processed"), by_clock=True)
            for epoch in record.epochs
            if epoch.epoch not in pending
        ]
        return [
            *stored,
            *(
                Point(name, name, self._finding(epoch, record), by_clock=True)
                for name, epoch in pending.items()
            ),
        ]

    def _finding(self, epoch: PendingEpoch, record: Record) -> Finding:
        if not epoch.missing:
            return self._arrived("all stations have arrived")
        hours = (record.now - epoch.first_arrival).total_seconds() / 3600.0
        return Finding(
            value=abs(hours),
            limit_value=self.hours,
            unit="h",
            broken=abs(hours) > self.hours,
            eased=False,
            what=f"{', '.join(epoch.missing)} missing {_after(hours)} the first station of {epoch.epoch} arrived;"
            f" allowed are {self.hours:g}",
        )

    def _arrived(self, what: str) -> Finding:
        """Nothing is waited for any more: for zero hours, that is."""
        return Finding(value=0.0, limit_value=self.hours, unit="h", broken=False, eased=True, what=what)


def _after(hours: float) -> str:
    if hours >= 0.0:
        return f"{hours:.1f} hours after"
    return f"by a clock that says {-hours:.1f} hours before"


KIND = RuleKind(
    name="late-station",
    description="a station of an epoch that has begun does not arrive",
    advice="Ask the crew, look for a broken upload, or end the epoch without the station by its marker EPOCH.complete.",
    rule=LateStationRule,
    apart=True,
)
