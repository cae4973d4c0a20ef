"""Put the tables of an epoch together and publish them whole; never let a worse result replace a better."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeVar

from storage.errors import StorageError
from storage.parquet import read_rows
from storage.publish import publish_epoch
from storage.records import (
    AccuracyRow,
    AxisCovarianceRow,
    AxisParameterRow,
    CoverageRow,
    EpochRow,
    PairRow,
    ReferenceLeanRow,
    RemovalRow,
    SchemeComparisonRow,
    SchemeRow,
    SliceRow,
    StationRow,
    SurfaceMapRow,
    TiltRow,
    VerdictRow,
)
from storage.tables import table_path
from storage.workspace import Workspace
from tasks.evaluation import Standard, compare_with_control
from tasks.verdict_rows import verdict_rows

Row = TypeVar("Row")
SchemeKeyed = TypeVar(
    "SchemeKeyed", bound=SliceRow | TiltRow | SchemeRow | AxisParameterRow | AxisCovarianceRow
)

RANK: Final = {"failed": 0, "degraded": 1, "ok": 2}


@dataclass(frozen=True, slots=True)
class EpochTables:
    """All rows of an epoch."""

    epoch: EpochRow
    stations: Sequence[StationRow]
    pairs: Sequence[PairRow]
    removals: Sequence[RemovalRow]
    coverage: Sequence[CoverageRow]
    slices: Sequence[SliceRow]
    tilt: Sequence[TiltRow]
    schemes: Sequence[SchemeRow]
    accuracy: Sequence[AccuracyRow]
    reference_leans: Sequence[ReferenceLeanRow] = ()
    scheme_comparison: Sequence[SchemeComparisonRow] = ()
    axis_parameters: Sequence[AxisParameterRow] = ()
    axis_covariances: Sequence[AxisCovarianceRow] = ()
    verdicts: Sequence[VerdictRow] = ()
    surface_map: Sequence[SurfaceMapRow] | None = None
    """None where the scheme that it rests on was not asked for."""

    def by_table(self) -> Mapping[str, Sequence[object]]:
        """Rows by the name of their table."""
        return {
            "epochs": [self.epoch],
            "stations": self.stations,
            "pairs": self.pairs,
            "removals": self.removals,
            "coverage": self.coverage,
            "surface_map": self.surface_map or (),
            "slices": self.slices,
            "tilt": self.tilt,
            "schemes": self.schemes,
            "accuracy": self.accuracy,
            "reference_leans": self.reference_leans,
            "scheme_comparison": self.scheme_comparison,
            "axis_parameters": self.axis_parameters,
            "axis_covariances": self.axis_covariances,
            "verdicts": self.verdicts,
        }


@dataclass(frozen=True, slots=True)
class Publication:
    """Whether the tables of the epoch changed, and the note to the user where the old ones were kept."""

    changed: bool
    kept_because: str | None = None


def publish(workspace: Workspace, tables: EpochTables) -> Publication:
    """Publish the tables of an epoch at once.

    An epoch that is published with a better state keeps it: a scan that has since gone missing or bad must
    not take a good result out of the record. A damaged table is no result, and is replaced.
    """
    new = tables.epoch
    before = _whole_rows(workspace, "epochs", new, EpochRow)
    if before and RANK[before[0].state] > RANK[new.state]:
        old = before[0]
        note = f"the result of run {old.run} ({old.state}) stays published; this run was {new.state}"
        return Publication(changed=False, kept_because=note)
    changed = publish_epoch(workspace, new.structure, new.epoch, tables.by_table())
    return Publication(changed=changed)


@dataclass(frozen=True, slots=True)
class Merged:
    """Tables with the published rows of other schemes, and the schemes whose rows did not fit."""

    tables: EpochTables
    left_out: tuple[str, ...] = ()


def with_other_schemes(workspace: Workspace, tables: EpochTables, standard: Standard) -> Merged:
    """Add the published rows of schemes that this run was not asked for, if they rest on the same shaft.

    Rows that rest on other scans, poses or points are left out: they would stand beside results they do not
    belong to. All that remain are compared with the control anew. The map of the surface rests on one scheme, and stays
    where that was not asked for.
    """
    here = {(row.scheme, row.method) for row in tables.schemes}
    others = _Others(workspace, tables.epoch, frozenset(here))
    if not _rest_on_same_shaft(workspace, tables):
        kept = others.rows("schemes", SchemeRow)
        return Merged(tables, tuple(dict.fromkeys(row.scheme for row in kept)))
    tilt = others.beside("tilt", TiltRow, tables.tilt)
    merged = replace(
        tables,
        slices=others.beside("slices", SliceRow, tables.slices),
        tilt=tilt,
        schemes=others.beside("schemes", SchemeRow, tables.schemes),
        axis_parameters=others.beside("axis_parameters", AxisParameterRow, tables.axis_parameters),
        axis_covariances=others.beside("axis_covariances", AxisCovarianceRow, tables.axis_covariances),
        accuracy=compare_with_control(tilt, standard).accuracy,
        verdicts=verdict_rows(tilt, standard),
        surface_map=_whole_rows(workspace, "surface_map", tables.epoch, SurfaceMapRow)
        if tables.surface_map is None
        else tables.surface_map,
    )
    return Merged(merged)


def _rest_on_same_shaft(workspace: Workspace, tables: EpochTables) -> bool:
    stations = _whole_rows(workspace, "stations", tables.epoch, StationRow)
    removals = _whole_rows(workspace, "removals", tables.epoch, RemovalRow)
    before = _whole_rows(workspace, "epochs", tables.epoch, EpochRow)
    return (
        stations == list(tables.stations)
        and removals == list(tables.removals)
        and [row.height_m for row in before] == [tables.epoch.height_m]
    )


def _whole_rows(workspace: Workspace, table: str, epoch: EpochRow, kind: type[Row]) -> list[Row]:
    """Rows of a table that are published for the epoch; none where it is not, or where the file is damaged."""
    path = table_path(workspace, table, epoch.structure, epoch.epoch)
    if not path.exists():
        return []
    try:
        return list(read_rows(path, table, kind))
    except StorageError:
        return []


@dataclass(frozen=True, slots=True)
class _Others:
    """The published rows of an epoch but for some schemes and methods."""

    workspace: Workspace
    epoch: EpochRow
    without: frozenset[tuple[str, str]]

    def beside(self, table: str, kind: type[SchemeKeyed], rows: Sequence[SchemeKeyed]) -> list[SchemeKeyed]:
        """Rows together with the published ones of the other schemes, in the order of schemes."""
        return sorted([*self.rows(table, kind), *rows], key=lambda row: (row.scheme, row.method))

    def rows(self, table: str, kind: type[SchemeKeyed]) -> list[SchemeKeyed]:
        """The published rows of the other schemes."""
        published = _whole_rows(self.workspace, table, self.epoch, kind)
        return [row for row in published if (row.scheme, row.method) not in self.without]
