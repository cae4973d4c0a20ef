"""The rows that tiltwatch stores: one dataclass a table, one annotated field a column."""

from storage.records.accuracy import AccuracyRow
from storage.records.alarm import AlarmRow
from storage.records.alarm_event import AlarmEventRow
from storage.records.axis_parameter import AxisCovarianceRow, AxisParameterRow
from storage.records.change_test import ChangeTestRow
from storage.records.column import Column, Field, columns_of
from storage.records.control_chart import ControlChartRow
from storage.records.coverage import CoverageCell, CoverageRow
from storage.records.epoch import EpochRow
from storage.records.pair import PairRow
from storage.records.reference_lean import ReferenceLeanRow
from storage.records.removal import RemovalRow
from storage.records.scheme import SchemeRow
from storage.records.scheme_comparison import SchemeComparisonRow
from storage.records.section import SectionFit, failed_section
from storage.records.slice import SliceRow
from storage.records.stage_run import StageRunRow
from storage.records.station import REGISTERED, StationRow
from storage.records.surface_map import SurfaceMapCell, SurfaceMapRow
from storage.records.tilt import TiltRow
from storage.records.trend import TrendRow
from storage.records.verdict import VerdictRow

TABLES: dict[str, type] = {
    "epochs": EpochRow,
    "stations": StationRow,
    "pairs": PairRow,
    "removals": RemovalRow,
    "coverage": CoverageRow,
    "surface_map": SurfaceMapRow,
    "slices": SliceRow,
    "tilt": TiltRow,
    "schemes": SchemeRow,
    "accuracy": AccuracyRow,
    "reference_leans": ReferenceLeanRow,
    "scheme_comparison": SchemeComparisonRow,
    "axis_parameters": AxisParameterRow,
    "axis_covariances": AxisCovarianceRow,
    "verdicts": VerdictRow,
    "change_tests": ChangeTestRow,
    "trends": TrendRow,
    "control_chart": ControlChartRow,
    "runs": StageRunRow,
    "alarm_events": AlarmEventRow,
}
"""Table name to record class; ``storage.tables`` says which are stored by epoch, by structure, by run or by event."""

__all__ = [
    "REGISTERED",
    "TABLES",
    "AccuracyRow",
    "AlarmEventRow",
    "AlarmRow",
    "AxisCovarianceRow",
    "AxisParameterRow",
    "ChangeTestRow",
    "Column",
    "ControlChartRow",
    "CoverageCell",
    "CoverageRow",
    "EpochRow",
    "Field",
    "PairRow",
    "ReferenceLeanRow",
    "RemovalRow",
    "SchemeComparisonRow",
    "SchemeRow",
    "SectionFit",
    "SliceRow",
    "StageRunRow",
    "StationRow",
    "SurfaceMapCell",
    "SurfaceMapRow",
    "TiltRow",
    "TrendRow",
    "VerdictRow",
    "columns_of",
    "failed_section",
]
