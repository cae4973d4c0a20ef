"""What the views and tables say, as rows of the record classes."""

from collections.abc import Mapping
from typing import TypeVar

import duckdb

from storage.catalog_reading import read_catalog
from storage.change import ChangeRow
from storage.errors import StorageError, UsageError
from storage.locks import publish_lock
from storage.parquet import read_rows, rows_from_table, schema_of
from storage.publish import recover
from storage.records import (
    TABLES,
    AccuracyRow,
    AlarmEventRow,
    AlarmRow,
    AxisCovarianceRow,
    AxisParameterRow,
    ChangeTestRow,
    ControlChartRow,
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
    columns_of,
)
from storage.surface_change import SurfaceChangeRow
from storage.tables import files_of, key_of
from storage.version import VersionChangeRow, VersionRow, VersionTiltRow
from storage.view_definitions import view_definition
from storage.workspace import Workspace

Row = TypeVar("Row")


def latest_epochs(ws: Workspace) -> list[EpochRow]:
    """The newest epoch of each structure, whatever became of it."""
    return _rows(ws, "latest", EpochRow, {}, "structure")


def epoch_rows(ws: Workspace, structure: str) -> list[EpochRow]:
    """The epochs of a structure, the earliest first."""
    return _rows(ws, "epochs", EpochRow, {"structure": structure}, "epoch_time, epoch")


def station_rows(ws: Workspace, structure: str, epoch: str) -> list[StationRow]:
    """The stations of an epoch."""
    return _rows(ws, "stations", StationRow, {"structure": structure, "epoch": epoch}, "station")


def pair_rows(ws: Workspace, structure: str, epoch: str) -> list[PairRow]:
    """How the stations of an epoch agree two by two."""
    return _rows(ws, "pairs", PairRow, {"structure": structure, "epoch": epoch}, "station, other")


def coverage_rows(ws: Workspace, structure: str, epoch: str) -> list[CoverageRow]:
    """How much of the shaft was seen in an epoch, from the bottom, clockwise from north."""
    chosen = {"structure": structure, "epoch": epoch}
    return _rows(ws, "coverage", CoverageRow, chosen, "z_low_m, azimuth_low_deg")


def surface_map_rows(ws: Workspace, structure: str, epoch: str) -> list[SurfaceMapRow]:
    """How far the surface is off its shape in an epoch, from the bottom, clockwise from north."""
    chosen = {"structure": structure, "epoch": epoch}
    return _rows(ws, "surface_map", SurfaceMapRow, chosen, "z_low_m, azimuth_deg")


def surface_change_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[SurfaceChangeRow]:
    """How far the surface moved against the reference epoch, from the bottom, clockwise from north."""
    order = "epoch_time, epoch, z_low_m, azimuth_deg"
    return _rows(ws, "surface_changes", SurfaceChangeRow, _chosen(structure, epoch), order)


def removal_rows(ws: Workspace, structure: str, epoch: str) -> list[RemovalRow]:
    """What preprocessing removed in an epoch, in the order in which it did."""
    return _rows(ws, "removals", RemovalRow, {"structure": structure, "epoch": epoch}, "step")


def scheme_rows(ws: Workspace, structure: str, epoch: str) -> list[SchemeRow]:
    """What became of the schemes of an epoch."""
    return _rows(ws, "schemes", SchemeRow, {"structure": structure, "epoch": epoch}, "scheme, method")


def slice_rows_of(ws: Workspace, structure: str, epoch: str) -> list[SliceRow]:
    """The slices of an epoch under every scheme and method, from the bottom."""
    chosen = {"structure": structure, "epoch": epoch}
    return _rows(ws, "slices", SliceRow, chosen, "scheme, method, slice_index")


def slice_rows(ws: Workspace, structure: str, epoch: str, scheme: str, method: str) -> list[SliceRow]:
    """The slices of an epoch under a scheme and method, from the bottom."""
    chosen = {"structure": structure, "epoch": epoch, "scheme": scheme, "method": method}
    return _rows(ws, "slices", SliceRow, chosen, "slice_index")


def tilt_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[TiltRow]:
    """The axes of a structure, of one epoch or of all, the earliest first."""
    return _rows(ws, "tilt", TiltRow, _chosen(structure, epoch), "epoch_time, epoch, scheme, method")


def accuracy_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[AccuracyRow]:
    """The comparison of the schemes with the control."""
    return _rows(ws, "accuracy", AccuracyRow, _chosen(structure, epoch), "epoch, scheme, method, quantity")


def reference_lean_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[ReferenceLeanRow]:
    """The leans measured by other means, of one epoch or of all, the earliest first."""
    return _rows(
        ws, "reference_leans", ReferenceLeanRow, _chosen(structure, epoch), "epoch_time, epoch, source"
    )


def verdict_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[VerdictRow]:
    """What every limit says, of one epoch or of all; the primary limit first."""
    order = "epoch, scheme, method, is_primary desc, limit_name"
    return _rows(ws, "verdicts", VerdictRow, _chosen(structure, epoch), order)


def scheme_comparison_rows(
    ws: Workspace, structure: str, epoch: str | None = None
) -> list[SchemeComparisonRow]:
    """The schemes and reference measurements beside the primary; the references after the schemes."""
    order = "epoch, scheme IS NULL, scheme, method, compared"
    return _rows(ws, "scheme_comparison", SchemeComparisonRow, _chosen(structure, epoch), order)


def change_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[ChangeRow]:
    """The changes against the reference epoch, the earliest first."""
    return _rows(ws, "changes", ChangeRow, _chosen(structure, epoch), "epoch_time, epoch, scheme, method")


def alarm_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[AlarmRow]:
    """The alarms of a structure, the earliest first."""
    return _rows(ws, "alarms", AlarmRow, _chosen(structure, epoch), "raised_at, epoch, rule")


def alarm_event_rows(ws: Workspace, structure: str) -> list[AlarmEventRow]:
    """What happened to the alarms of a structure, the earliest first."""
    return _rows(ws, "alarm_events", AlarmEventRow, {"structure": structure}, "event")


def axis_parameter_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[AxisParameterRow]:
    """The parameters of the axes of a structure, in the order of their places."""
    order = "epoch, scheme, method, place"
    return _rows(ws, "axis_parameters", AxisParameterRow, _chosen(structure, epoch), order)


def axis_covariance_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[AxisCovarianceRow]:
    """The covariances of the parameters of the axes of a structure."""
    order = "epoch, scheme, method, place_1, place_2"
    return _rows(ws, "axis_covariances", AxisCovarianceRow, _chosen(structure, epoch), order)


def change_test_rows(ws: Workspace, structure: str, epoch: str | None = None) -> list[ChangeTestRow]:
    """The tests of what changed against the reference epoch, the earliest epoch first."""
    order = "epoch_time, epoch, scheme, method, quantity"
    return _rows(ws, "change_tests", ChangeTestRow, _chosen(structure, epoch), order)


def trend_rows(ws: Workspace, structure: str) -> list[TrendRow]:
    """The trends of a structure, one a scheme and method."""
    return _rows(ws, "trends", TrendRow, {"structure": structure}, "scheme, method")


def control_chart_rows(ws: Workspace, structure: str) -> list[ControlChartRow]:
    """The control charts of a structure, the earliest epoch first."""
    order = "scheme, method, epoch_time, epoch"
    return _rows(ws, "control_chart", ControlChartRow, {"structure": structure}, order)


def run_rows(ws: Workspace, run: str) -> list[StageRunRow]:
    """The stages of a run, in the order in which they were asked for."""
    return _rows(ws, "runs", StageRunRow, {"run": run}, "started_at, epoch, stage")


def run_rows_of(ws: Workspace, structure: str, epoch: str | None = None) -> list[StageRunRow]:
    """What the stages of all runs did for a structure, for one epoch or for all, the earliest first."""
    return _rows(ws, "runs", StageRunRow, _chosen(structure, epoch), "started_at, run, epoch, stage")


def version_rows(ws: Workspace, structure: str) -> list[VersionRow]:
    """The epochs that were put aside, in the order in which they were."""
    return _rows(ws, "versions", VersionRow, {"structure": structure}, "archived_at, version, epoch")


def version_tilt_rows(ws: Workspace, structure: str, version: str) -> list[VersionTiltRow]:
    """The axes of a version, the earliest epoch first."""
    chosen = {"structure": structure, "version": version}
    return _rows(ws, "version_tilt", VersionTiltRow, chosen, "epoch_time, epoch, scheme, method")


def version_change_rows(ws: Workspace, structure: str, version: str) -> list[VersionChangeRow]:
    """What has become of the axes of a version, the earliest epoch first."""
    chosen = {"structure": structure, "version": version}
    return _rows(ws, "version_changes", VersionChangeRow, chosen, "epoch_time, epoch, scheme, method")


def rows_of(
    ws: Workspace, record: type[Row], structure: str | None = None, part: str | None = None
) -> list[Row]:
    """Rows of a table from its Parquet files, of one structure and one epoch (of runs: one run) or of all.

    For the program itself, between publishing and the next catalog; others read the views.

    Raises
    ------
    UsageError
        If the record class is not that of a table.
    StorageError
        If a file is damaged.
    """
    tables = [name for name, stored in TABLES.items() if stored is record]
    if not tables:
        raise UsageError(f"{record.__name__} is not stored as a table; known: {', '.join(TABLES)}")
    with publish_lock(ws):
        recover(ws)
        paths = [
            path
            for path in files_of(ws, tables[0])
            if structure in (None, key_of(path).structure) and part in (None, key_of(path).epoch)
        ]
        return [row for path in paths for row in read_rows(path, tables[0], record)]


def _chosen(structure: str, epoch: str | None) -> dict[str, str]:
    return {"structure": structure} if epoch is None else {"structure": structure, "epoch": epoch}


def _rows(ws: Workspace, view: str, record: type[Row], chosen: Mapping[str, str], order: str) -> list[Row]:
    columns = ", ".join(field.name for field in columns_of(record))
    where = " AND ".join(f"{column} = ?" for column in chosen) or "true"
    sql = f"SELECT {columns} FROM main.{view_definition(view).name} WHERE {where} ORDER BY {order}"  # noqa: S608
    with read_catalog(ws) as connection:
        try:
            content = connection.sql(sql, params=list(chosen.values())).to_arrow_table()
        except duckdb.Error as fault:
            first_line = str(fault).splitlines()[0]
            raise StorageError(
                f"view {view} of {ws.catalog} cannot be read ({first_line}); delete the catalog and run again: "
                "it is rebuilt from the tables"
            ) from fault
    return rows_from_table(content.cast(schema_of(view, record)), record)
