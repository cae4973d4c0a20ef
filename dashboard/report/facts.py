"""Everything that a report of an epoch says, gathered from the catalog in one place: this epoch and those before it."""

from dataclasses import dataclass
from datetime import datetime

from dashboard.report.alarm_log import AlarmThen, alarms_at
from dashboard.report.settings import Settings
from storage.errors import StorageError
from storage.records import (
    AccuracyRow,
    AxisParameterRow,
    ChangeTestRow,
    CoverageRow,
    EpochRow,
    PairRow,
    ReferenceLeanRow,
    RemovalRow,
    SchemeComparisonRow,
    SchemeRow,
    SliceRow,
    StageRunRow,
    StationRow,
    SurfaceMapRow,
    TiltRow,
    TrendRow,
    VerdictRow,
)
from storage.views import (
    ChangeRow,
    accuracy_rows,
    alarm_event_rows,
    axis_parameter_rows,
    change_test_rows,
    coverage_rows,
    one_catalog,
    pair_rows,
    reference_lean_rows,
    removal_rows,
    run_rows,
    scheme_comparison_rows,
    scheme_rows,
    slice_rows_of,
    station_rows,
    surface_map_rows,
    tilt_rows,
    trend_rows,
    verdict_rows,
)
from storage.views.condition import Condition, conditions
from storage.workspace import Workspace


@dataclass(frozen=True, slots=True)
class Facts:
    """Rows of the catalog that a report is made of.

    ``settings`` is None where those of the run are not kept any more, ``trend`` where there is none or it looks at
    epochs after this one, which a report of this epoch must not.
    """

    structure: str
    primary: tuple[str, str]
    settings: Settings | None
    history: tuple[Condition, ...]
    """Conditions of the epochs up to this one, which is the last."""
    stations: tuple[StationRow, ...]
    pairs: tuple[PairRow, ...]
    removals: tuple[RemovalRow, ...]
    coverage: tuple[CoverageRow, ...]
    surface: tuple[SurfaceMapRow, ...]
    slices: tuple[SliceRow, ...]
    schemes: tuple[SchemeRow, ...]
    tilts: tuple[TiltRow, ...]
    accuracy: tuple[AccuracyRow, ...]
    references: tuple[ReferenceLeanRow, ...]
    comparison: tuple[SchemeComparisonRow, ...]
    verdicts: tuple[VerdictRow, ...]
    changes: tuple[ChangeRow, ...]
    tests: tuple[ChangeTestRow, ...]
    parameters: tuple[AxisParameterRow, ...]
    alarms: tuple[AlarmThen, ...]
    trend: TrendRow | None
    trend_goes_on: bool
    """Whether a trend is stored that knows of later epochs."""
    stages: tuple[StageRunRow, ...]
    library_versions: tuple[str, ...]
    program_version: str

    @property
    def now(self) -> Condition:
        """State of the structure in the epoch of the report."""
        return self.history[-1]

    @property
    def epoch(self) -> EpochRow:
        """The epoch of the report."""
        return self.now.epoch

    @property
    def name(self) -> str:
        """Name of the structure; its id where none is known."""
        return (self.settings.name if self.settings else None) or self.structure

    @property
    def published_at(self) -> datetime:
        """When the last stage of the epoch began in the run that published it: the date of the report."""
        return max((row.started_at for row in self.stages), default=self.epoch.epoch_time)

    @property
    def primary_limit(self) -> VerdictRow | None:
        """What the limit that counts says of the result that counts."""
        return next((row for row in self.primary_verdicts if row.is_primary), None)

    @property
    def primary_verdicts(self) -> tuple[VerdictRow, ...]:
        """What all limits say of the result that counts."""
        return tuple(row for row in self.verdicts if (row.scheme, row.method) == self.primary)

    @property
    def primary_slices(self) -> tuple[SliceRow, ...]:
        """The slices of the result that counts, from the bottom."""
        return tuple(row for row in self.slices if (row.scheme, row.method) == self.primary)


@dataclass(frozen=True, slots=True)
class Origin:
    """Which epoch of which structure a report is of, and what is known beside the catalog."""

    workspace: Workspace
    structure: str
    epoch: str
    primary: tuple[str, str]
    settings: Settings | None
    library_versions: tuple[str, ...]
    program_version: str


def gather(origin: Origin) -> Facts:
    """Read the facts of a report.

    Raises
    ------
    StorageError
        If the catalog cannot be read or does not hold the epoch.
    """
    with one_catalog(origin.workspace):
        return _gathered(origin)


def _gathered(origin: Origin) -> Facts:
    ws, structure, epoch = origin.workspace, origin.structure, origin.epoch
    history = _history(origin)
    chosen = history[-1].epoch
    known = {condition.epoch.epoch for condition in history}
    trend, goes_on = _trend(origin, chosen)
    return Facts(
        structure,
        origin.primary,
        origin.settings,
        history,
        tuple(station_rows(ws, structure, epoch)),
        tuple(pair_rows(ws, structure, epoch)),
        tuple(removal_rows(ws, structure, epoch)),
        tuple(coverage_rows(ws, structure, epoch)),
        tuple(surface_map_rows(ws, structure, epoch)),
        tuple(slice_rows_of(ws, structure, epoch)),
        tuple(scheme_rows(ws, structure, epoch)),
        tuple(tilt_rows(ws, structure, epoch)),
        tuple(accuracy_rows(ws, structure, epoch)),
        tuple(reference_lean_rows(ws, structure, epoch)),
        tuple(scheme_comparison_rows(ws, structure, epoch)),
        tuple(verdict_rows(ws, structure, epoch)),
        tuple(condition.change for condition in history if condition.change is not None),
        tuple(change_test_rows(ws, structure, epoch)),
        tuple(axis_parameter_rows(ws, structure, epoch)),
        alarms_at(alarm_event_rows(ws, structure), known),
        trend,
        goes_on,
        tuple(row for row in run_rows(ws, chosen.run) if row.epoch == epoch and row.structure == structure),
        origin.library_versions,
        origin.program_version,
    )


def _history(origin: Origin) -> tuple[Condition, ...]:
    found = conditions(origin.workspace, origin.structure, origin.primary)
    places = [place for place, each in enumerate(found) if each.epoch.epoch == origin.epoch]
    if not places:
        stored = ", ".join(each.epoch.epoch for each in found) or "none"
        raise StorageError(
            f"{origin.workspace.root} holds no epoch {origin.epoch!r} of {origin.structure}; stored: {stored}; "
            "`tiltwatch run FILE` processes what is missing"
        )
    return tuple(found[: places[0] + 1])


def _trend(origin: Origin, epoch: EpochRow) -> tuple[TrendRow | None, bool]:
    rows = [
        row
        for row in trend_rows(origin.workspace, origin.structure)
        if (row.scheme, row.method) == origin.primary
    ]
    if not rows:
        return None, False
    goes_on = rows[0].last_time > epoch.epoch_time
    return (None, True) if goes_on else (rows[0], False)
