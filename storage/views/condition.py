"""The state of a structure in an epoch: what was found, against which limit, how it changed, how good the data are."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from storage.records import AlarmRow, EpochRow, TiltRow
from storage.views import ChangeRow, alarm_rows, change_rows, epoch_rows, one_catalog, tilt_rows
from storage.workspace import Workspace

COVERAGE: Final = 2.0
"""Expanded uncertainties are stated for k = 2, about 95 %."""

FULL_COVERAGE_DEG: Final = 300.0
"""With so much of the circumference the centre of a circle is at most 15 % less certain than with all of it; with less
that grows fast: 28 % at 270 deg, 130 % at 180 (science.md section 3)."""

WORTHWHILE_GAIN: Final = 0.15
"""A station that lowers the sigma by this share is worth the way: nine stations for eight lower it by 6 %."""

ACTIVE_ALARMS: Final = ("new", "acknowledged")


class Level(IntEnum):
    """How grave the state is; the highest wins."""

    OK = 0
    QUALITY = 1
    WARNING = 2
    ALARM = 3


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a state is not ok, and how grave that is."""

    level: Level
    what: str


@dataclass(frozen=True, slots=True)
class Condition:
    """State of a structure in an epoch under the primary scheme and method.

    ``tilt`` is None where the primary gave no axis; ``change`` where the epoch is the reference, or one of the
    two has no axis.
    """

    epoch: EpochRow
    primary: tuple[str, str]
    tilt: TiltRow | None
    change: ChangeRow | None
    reasons: tuple[Reason, ...]

    @property
    def level(self) -> Level:
        """The gravest of the reasons."""
        return max((reason.level for reason in self.reasons), default=Level.OK)

    @property
    def deviation_u_m(self) -> float | None:
        """Expanded uncertainty (k = 2) of the deviation [m]."""
        sigma = self.tilt.deviation_sigma_m if self.tilt else None
        return None if sigma is None else COVERAGE * sigma

    @property
    def next_station_gain(self) -> float | None:
        """Share by which one more station would lower the predicted sigma of the lean; None where that is not known."""
        now, then = self.epoch.stations_sigma_arcsec, self.epoch.next_station_sigma_arcsec
        return None if now is None or then is None else 1.0 - then / now

    @property
    def lacks_a_station(self) -> bool:
        """Whether a side of the shaft is unseen, or one more station would lower the sigma of the lean by much."""
        covered_deg, gain = self.epoch.coverage_deg, self.next_station_gain
        return (covered_deg is not None and covered_deg < FULL_COVERAGE_DEG) or (
            gain is not None and gain > WORTHWHILE_GAIN
        )

    @property
    def change_u_m(self) -> float | None:
        """Expanded uncertainty (k = 2) of the movement since the reference [m]."""
        sigma = self.change.sigma_top_m if self.change else None
        return None if sigma is None else COVERAGE * sigma


def conditions(workspace: Workspace, structure: str, primary: tuple[str, str]) -> list[Condition]:
    """State of every stored epoch of a structure, the earliest first.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    with one_catalog(workspace):
        return _conditions(workspace, structure, (primary[0], primary[1]))


def _conditions(workspace: Workspace, structure: str, scheme_method: tuple[str, str]) -> list[Condition]:
    tilts = {
        row.epoch: row for row in tilt_rows(workspace, structure) if (row.scheme, row.method) == scheme_method
    }
    changes = {
        row.epoch: row
        for row in change_rows(workspace, structure)
        if (row.scheme, row.method) == scheme_method
    }
    alarms = [row for row in alarm_rows(workspace, structure) if is_active(row)]
    epochs = epoch_rows(workspace, structure)
    return [
        _condition(
            epoch,
            scheme_method,
            tilts.get(epoch.epoch),
            changes.get(epoch.epoch),
            # what lasts concerns the present, whichever epoch its value is of
            alarms if epoch is epochs[-1] else [alarm for alarm in alarms if alarm.epoch == epoch.epoch],
            is_first=epoch is epochs[0],
        )
        for epoch in epochs
    ]


def is_active(alarm: AlarmRow) -> bool:
    """Whether an alarm counts: neither eased nor muted nor closed."""
    return alarm.state in ACTIVE_ALARMS and alarm.eased_at is None


def level_of(alarms: Sequence[AlarmRow]) -> Level:
    """The gravest of the alarms that count."""
    return max(
        (_BY_SEVERITY.get(alarm.severity, Level.OK) for alarm in alarms if is_active(alarm)), default=Level.OK
    )


def sorted_alarms(alarms: Sequence[AlarmRow]) -> list[AlarmRow]:
    """The active ones first, in them the gravest, in these the newest."""
    newest_first = sorted(alarms, key=lambda alarm: alarm.raised_at, reverse=True)
    return sorted(
        newest_first,
        key=lambda alarm: (
            not is_active(alarm),
            alarm.state == "closed",
            -_BY_SEVERITY.get(alarm.severity, Level.OK),
        ),
    )


def _condition(
    epoch: EpochRow,
    primary: tuple[str, str],
    tilt: TiltRow | None,
    change: ChangeRow | None,
    alarms: list[AlarmRow],
    *,
    is_first: bool,
) -> Condition:
    reasons = [*_quality(epoch, primary, tilt), *_verdict(tilt), *_moved(change)]
    if tilt is not None and not epoch.is_reference and not is_first:
        reasons += _untold(change)
    for alarm in alarms:
        if alarm.severity in _BY_SEVERITY:
            at = f" (epoch {alarm.epoch})" if alarm.epoch else ""
            told = f": {alarm.what}" if alarm.what else ""
            reasons.append(Reason(_BY_SEVERITY[alarm.severity], f"rule {alarm.rule}{at}{told}"))
    return Condition(epoch, primary, tilt, change, tuple(reasons))


_BY_SEVERITY: Final = {"warning": Level.WARNING, "alarm": Level.ALARM}


def _quality(epoch: EpochRow, primary: tuple[str, str], tilt: TiltRow | None) -> list[Reason]:
    reasons = []
    if epoch.state != "ok":
        because = f": {epoch.reason}" if epoch.reason else ""
        reasons.append(Reason(Level.QUALITY, f"the epoch is {epoch.state}{because}"))
    if tilt is None:
        reasons.append(Reason(Level.QUALITY, f"the primary {primary[0]}/{primary[1]} gave no axis"))
    return reasons


def _verdict(tilt: TiltRow | None) -> list[Reason]:
    if tilt is not None and tilt.verdict == "fail":
        return [Reason(Level.ALARM, "the deviation is above its limit")]
    if tilt is not None and tilt.verdict == "cannot tell":
        return [Reason(Level.WARNING, "the limit lies within the uncertainty of the deviation")]
    return []


def _untold(change: ChangeRow | None) -> list[Reason]:
    """Where nothing can be said of a movement, nothing is in order."""
    if change is None:
        what = "whether it moved cannot be told: there is no axis of the reference epoch to count from"
        return [Reason(Level.QUALITY, what)]
    if change.significant is None:
        what = f"whether it moved since {change.reference_epoch} cannot be told: the covariance of the change is unknown"
        return [Reason(Level.QUALITY, what)]
    return []


def _moved(change: ChangeRow | None) -> list[Reason]:
    if change is not None and change.significant:
        return [Reason(Level.WARNING, f"the change since {change.reference_epoch} is significant")]
    return []
