"""Put the tables of an epoch together and publish them whole; never let a worse result replace a better."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeVar

from storage.parquet import read_rows
from storage.publish import publish_epoch
from storage.records import (
    AccuracyRow,
    EpochRow,
    RemovalRow,
    SchemeRow,
    SliceRow,
    StationRow,
    TiltRow,
)
from storage.tables import table_path
from storage.workspace import Workspace

Row = TypeVar("Row")
SchemeKeyed = TypeVar("SchemeKeyed", bound=SliceRow | TiltRow | SchemeRow | AccuracyRow)

RANK: Final = {"failed": 0, "degraded": 1, "ok": 2}


@dataclass(frozen=True, slots=True)
class EpochTables:
    """All rows of an epoch."""

    epoch: EpochRow
    stations: Sequence[StationRow]
    removals: Sequence[RemovalRow]
    slices: Sequence[SliceRow]
    tilt: Sequence[TiltRow]
    schemes: Sequence[SchemeRow]
    accuracy: Sequence[AccuracyRow]

    def by_table(self) -> Mapping[str, Sequence[object]]:
        """Rows by the name of their table."""
        return {
            "epochs": [self.epoch],
            "stations": self.stations,
            "removals": self.removals,
            "slices": self.slices,
            "tilt": self.tilt,
            "schemes": self.schemes,
            "accuracy": self.accuracy,
            "alarms": [],
        }


@dataclass(frozen=True, slots=True)
class Publication:
    """Whether the tables of the epoch changed, and the note to the user where the old ones were kept."""

    changed: bool
    kept_because: str | None = None


def publish(workspace: Workspace, tables: EpochTables) -> Publication:
    """Publish the tables of an epoch at once.

    An epoch that is published with a better state keeps it: a scan that has since gone missing or bad must
    not take a good result out of the record.
    """
    new = tables.epoch
    before = published_rows(workspace, "epochs", new, EpochRow)
    if before and RANK[before[0].state] > RANK[new.state]:
        old = before[0]
        note = f"the result of run {old.run} ({old.state}) stays published; this run was {new.state}"
        return Publication(changed=False, kept_because=note)
    changed = publish_epoch(workspace, new.structure, new.epoch, tables.by_table())
    return Publication(changed=changed)


def with_other_schemes(workspace: Workspace, tables: EpochTables) -> EpochTables:
    """Add the published rows of schemes that this run was not asked for, if they rest on the same stations.

    Rows that rest on other scans or poses are left out: they would stand beside results they do not belong to.
    """
    if published_rows(workspace, "stations", tables.epoch, StationRow) != list(tables.stations):
        return tables
    here = {(row.scheme, row.method) for row in tables.schemes}
    others = _Others(workspace, tables.epoch, frozenset(here))
    return replace(
        tables,
        slices=others.beside("slices", SliceRow, tables.slices),
        tilt=others.beside("tilt", TiltRow, tables.tilt),
        schemes=others.beside("schemes", SchemeRow, tables.schemes),
        accuracy=others.beside("accuracy", AccuracyRow, tables.accuracy),
    )


def published_rows(workspace: Workspace, table: str, epoch: EpochRow, kind: type[Row]) -> list[Row]:
    """Rows of a table that are published for the epoch; none where it is not."""
    path = table_path(workspace, table, epoch.structure, epoch.epoch)
    return list(read_rows(path, table, kind)) if path.exists() else []


@dataclass(frozen=True, slots=True)
class _Others:
    """The published rows of an epoch but for some schemes and methods."""

    workspace: Workspace
    epoch: EpochRow
    without: frozenset[tuple[str, str]]

    def beside(self, table: str, kind: type[SchemeKeyed], rows: Sequence[SchemeKeyed]) -> list[SchemeKeyed]:
        """Rows together with the published ones of the other schemes, in the order of schemes."""
        published = published_rows(self.workspace, table, self.epoch, kind)
        kept = [row for row in published if (row.scheme, row.method) not in self.without]
        return sorted([*kept, *rows], key=lambda row: (row.scheme, row.method))
