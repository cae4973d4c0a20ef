"""What one epoch of a run is worked on with, and what its stages produce on the way."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from flows.stage_calls import StageCalls
from storage.records import AccuracyRow, TiltRow
from storage.workspace import Workspace
from tasks.epoch_tables import ScanInput, SchemeOutcome
from tasks.level_check import LevelCheck
from tasks.plan import PlannedAxis, PlannedScan
from tasks.produced import Json, Produced
from tasks.settings import Campaign, Epoch


@dataclass(frozen=True, slots=True)
class EpochWork:
    """Campaign, epoch, place and calls: what every step needs."""

    campaign: Campaign
    epoch: Epoch
    workspace: Workspace
    calls: StageCalls
    axes: tuple[PlannedAxis, ...]
    partial: bool
    """Only some schemes were asked for; the rows of the others stay."""


@dataclass(frozen=True, slots=True)
class ReadScan:
    """A planned scan and what became of it."""

    plan: PlannedScan
    input: ScanInput
    produced: Produced | None


@dataclass(slots=True)
class EpochResult:
    """What the steps have so far; ``reasons`` are those why the epoch is not ok, ``notes`` leave it ok.

    ``stable`` are references to the stable surroundings of the reference epoch. ``levels`` are the level checks of
    stations, ``suspects`` why a station is suspect by its level and still used.
    """

    scans: tuple[ReadScan, ...] = ()
    stable: Mapping[str, Json] | None = None
    registration: Produced | None = None
    shaft: Produced | None = None
    levels: dict[str, LevelCheck] = field(default_factory=dict)
    suspects: dict[str, str] = field(default_factory=dict)
    coverage: Produced | None = None
    outcomes: tuple[SchemeOutcome, ...] = ()
    surface_map: Produced | None = None
    tilt: tuple[TiltRow, ...] = ()
    accuracy: tuple[AccuracyRow, ...] = ()
    reasons: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    bad_input: bool = False

    @property
    def used(self) -> tuple[ReadScan, ...]:
        """The scans that were read and not left out."""
        return tuple(scan for scan in self.scans if scan.produced is not None and scan.input.refusal is None)

    def refuse(self, reason: str) -> None:
        """Put down a reason that lies in the input."""
        self.reasons.append(reason)
        self.bad_input = True

    def take_refusal(self, stage: str, produced: Produced) -> bool:
        """Put down why a stage refused its input, and say whether it did."""
        if produced.refusal is not None:
            self.refuse(f"{stage}: {produced.refusal}")
        return produced.refusal is not None

    def leave_out(self, station: str, reason: str) -> None:
        """Go on without a station, and put down why."""
        self.reasons.append(f"station {station}: {reason}")
        self.scans = tuple(
            replace(scan, input=replace(scan.input, refusal=reason)) if scan.plan.station == station else scan
            for scan in self.scans
        )
