"""The rows that tiltwatch stores: one dataclass a table, one annotated field a column."""

from storage.records.accuracy import AccuracyRow
from storage.records.alarm import AlarmRow
from storage.records.column import Column, Field, columns_of
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
from storage.records.station import StationRow
from storage.records.surface_map import SurfaceMapCell, SurfaceMapRow
from storage.records.tilt import TiltRow

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
    "alarms": AlarmRow,
    "runs": StageRunRow,
}
"""Table name to record class; ``runs`` is stored by run, the others by structure and epoch."""

__all__ = [
    "TABLES",
    "AccuracyRow",
    "AlarmRow",
    "Column",
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
    "columns_of",
    "failed_section",
]
