"""A quantity of the axis over the epochs, with its uncertainty and what is missing."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from storage.records import EpochRow, TiltRow


@dataclass(frozen=True, slots=True)
class SeriesPoint:
    """The axis of an epoch; ``tilt`` is None where there is none, and ``reason`` says why.

    ``doubtful`` is for epochs that are not whole: something failed in them, or their axis has a warning.
    """

    epoch: str
    time: datetime
    tilt: TiltRow | None
    doubtful: bool
    reason: str | None


def series_points(epochs: Sequence[EpochRow], tilts: Sequence[TiltRow]) -> list[SeriesPoint]:
    """Put the axes of one scheme and method beside their epochs, the earliest first; no epoch is left out."""
    by_epoch = {row.epoch: row for row in tilts}
    return [_point(epoch, by_epoch.get(epoch.epoch)) for epoch in epochs]


def _point(epoch: EpochRow, tilt: TiltRow | None) -> SeriesPoint:
    if tilt is None:
        reason = epoch.reason or "this scheme and method gave no axis"
        return SeriesPoint(epoch.epoch, epoch.epoch_time, None, doubtful=True, reason=reason)
    doubtful = epoch.state != "ok"
    return SeriesPoint(
        epoch.epoch, epoch.epoch_time, tilt, doubtful, epoch.reason if doubtful else tilt.warning
    )
