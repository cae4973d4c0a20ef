"""What one epoch of a run is worked on with, and what its stages produce on the way."""

from dataclasses import dataclass, field

from flows.stage_calls import StageCalls
from storage.records import AccuracyRow, TiltRow
from storage.workspace import Workspace
from tasks.epoch_tables import ScanInput, SchemeOutcome
from tasks.plan import PlannedAxis, PlannedScan
from tasks.produced import Produced
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
    """What the steps have so far; ``reasons`` are those why the epoch is not ok, ``notes`` leave it ok."""

    scans: tuple[ReadScan, ...] = ()
    registration: Produced | None = None
    shaft: Produced | None = None
    outcomes: tuple[SchemeOutcome, ...] = ()
    tilt: tuple[TiltRow, ...] = ()
    accuracy: tuple[AccuracyRow, ...] = ()
    reasons: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    bad_input: bool = False

    @property
    def used(self) -> tuple[ReadScan, ...]:
        """The scans that were read."""
        return tuple(scan for scan in self.scans if scan.produced is not None and scan.input.refusal is None)

    def refuse(self, reason: str) -> None:
        """Put down a reason that lies in the input."""
        self.reasons.append(reason)
        self.bad_input = True
