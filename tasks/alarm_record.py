"""What rules of alarms look at, out of the catalog: the record of a structure under its primary scheme and method."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TypeVar

from storage.records import ChangeTestRow, ControlChartRow, EpochRow, ReferenceLeanRow, TiltRow, TrendRow
from storage.views import (
    ChangeRow,
    change_rows,
    change_test_rows,
    control_chart_rows,
    epoch_rows,
    reference_lean_rows,
    tilt_rows,
    trend_rows,
)
from storage.workspace import Workspace
from tasks.alarms import Change, ChartPoint, Deviation, EpochState, PendingEpoch, Record, Trend
from tasks.settings import Campaign

LEAN = "lean"

Changes = dict[str, dict[str, Change]]
"""Change by epoch and quantity."""

Row = TypeVar("Row", TiltRow, ControlChartRow, ChangeRow, ChangeTestRow, TrendRow)


def read_record(
    workspace: Workspace, campaign: Campaign, now: datetime, pending: Sequence[PendingEpoch] | None
) -> Record:
    """Read what is known of a structure from the catalog.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    structure, primary = campaign.structure.id, _pair(campaign.report.primary)
    epochs = epoch_rows(workspace, structure)
    changes = _Changes.read(workspace, structure)
    found = _Found(
        tilts={row.epoch: row for row in _of(tilt_rows(workspace, structure), primary)},
        charts={row.epoch: row for row in _of(control_chart_rows(workspace, structure), primary)},
        changes=changes.of(primary),
        control_changes=_control_changes(workspace, campaign, changes),
    )
    trends = _of(trend_rows(workspace, structure), primary)
    return Record(
        epochs=tuple(found.state_of(row) for row in epochs),
        trend=_trend(trends[0]) if trends else None,
        now=now,
        pending=None if pending is None else tuple(pending),
    )


@dataclass(frozen=True, slots=True)
class _Found:
    """Rows of the primary by epoch."""

    tilts: Mapping[str, TiltRow]
    charts: Mapping[str, ControlChartRow]
    changes: Changes
    control_changes: Changes

    def state_of(self, row: EpochRow) -> EpochState:
        tilt, chart = self.tilts.get(row.epoch), self.charts.get(row.epoch)
        return EpochState(
            epoch=row.epoch,
            time=row.epoch_time,
            state=row.state,
            reason=row.reason,
            n_stations_used=row.n_stations_used,
            coverage_deg=row.coverage_deg,
            deviation=None
            if tilt is None
            else Deviation(
                deviation_m=tilt.deviation_m,
                sigma_m=tilt.deviation_sigma_m,
                allowable_m=tilt.allowable_m,
                verdict=tilt.verdict,
            ),
            changes=self.changes.get(row.epoch, {}),
            control_changes=self.control_changes.get(row.epoch, {}),
            chart=None
            if chart is None
            else ChartPoint(cusum=chart.cusum, watch_limit=chart.watch_limit, alarm_limit=chart.alarm_limit),
        )


@dataclass(frozen=True, slots=True)
class _Changes:
    """All changes against the reference epoch; of the lean as the view ``changes`` has it, of the rest as tested."""

    leans: Sequence[ChangeRow]
    tests: Sequence[ChangeTestRow]

    @staticmethod
    def read(workspace: Workspace, structure: str) -> "_Changes":
        return _Changes(change_rows(workspace, structure), change_test_rows(workspace, structure))

    def of(self, pair: tuple[str, str]) -> Changes:
        found: Changes = {row.epoch: {LEAN: _lean_change(row)} for row in _of(self.leans, pair)}
        for row in _of(self.tests, pair):
            if row.quantity != LEAN and row.size_m is not None:
                found.setdefault(row.epoch, {})[row.quantity] = _tested_change(row, row.size_m)
        return found


def _control_changes(workspace: Workspace, campaign: Campaign, changes: _Changes) -> Changes:
    """Changes as the control measured them by other means; a control scheme shares the scans, and is no witness."""
    control = campaign.report.control
    if not isinstance(control, str):
        return {}
    rows = reference_lean_rows(workspace, campaign.structure.id)
    reference = next((row.reference_epoch for row in changes.leans), None)
    return _measured_changes([row for row in rows if row.source == control], reference)


def _measured_changes(rows: Sequence[ReferenceLeanRow], reference: str | None) -> Changes:
    base = next((row for row in rows if row.epoch == reference), None)
    if base is None:
        return {}
    return {row.epoch: {LEAN: _measured_change(row, base)} for row in rows if row.epoch != reference}


def _measured_change(row: ReferenceLeanRow, base: ReferenceLeanRow) -> Change:
    east, north = row.lean_east - base.lean_east, row.lean_north - base.lean_north
    variance = row.sigma**2 + base.sigma**2
    statistic = (east**2 + north**2) / variance
    return Change(
        size_m=row.height_m * math.hypot(east, north),
        sigma_m=row.height_m * math.sqrt(variance),
        statistic=statistic,
        freedom=2,
        p_value=math.exp(-statistic / 2.0),
        east=east,
        north=north,
        reference_epoch=base.epoch,
    )


def _lean_change(row: ChangeRow) -> Change:
    return Change(
        size_m=row.d_top_m,
        sigma_m=row.sigma_top_m,
        statistic=row.chi2,
        freedom=2,
        p_value=row.p_value,
        east=row.d_lean_east,
        north=row.d_lean_north,
        reference_epoch=row.reference_epoch,
    )


def _tested_change(row: ChangeTestRow, size_m: float) -> Change:
    return Change(
        size_m=size_m,
        sigma_m=row.sigma_m,
        statistic=row.statistic,
        freedom=row.freedom,
        p_value=row.p_value,
        east=row.d_east,
        north=row.d_north,
        reference_epoch=row.reference_epoch,
    )


def _trend(row: TrendRow) -> Trend:
    return Trend(
        last_epoch=row.last_epoch,
        last_time=row.last_time,
        rate_m_per_year=row.rate_m_per_year,
        rate_sigma_m_per_year=row.rate_sigma_m_per_year,
        rate_significant=row.rate_significant,
        limit_reached_at=row.limit_reached_at,
        limit_earliest_at=row.limit_earliest_at,
    )


def _of(rows: Iterable[Row], pair: tuple[str, str]) -> list[Row]:
    return [row for row in rows if (row.scheme, row.method) == pair]


def _pair(scheme_method: Sequence[str]) -> tuple[str, str]:
    return scheme_method[0], scheme_method[1]
