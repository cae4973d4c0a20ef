"""The rows that tiltwatch stores: one dataclass a table, one annotated field a column."""

from storage.records.accuracy import AccuracyRow
from storage.records.alarm import AlarmRow
from storage.records.column import Column, Field, columns_of
from storage.records.coverage import CoverageCell, CoverageRow
from storage.records.epoch import EpochRow
from storage.records.pair import PairRow
from storage.records.removal import RemovalRow
from storage.records.scheme import SchemeRow
from storage.records.section import SectionFit
from storage.records.slice import SliceRow
from storage.records.stage_run import StageRunRow
from storage.records.station import StationRow
from storage.records.tilt import TiltRow

TABLES: dict[str, type] = {
    "epochs": EpochRow,
    "stations": StationRow,
    "pairs": PairRow,
    "removals": RemovalRow,
    "coverage": CoverageRow,
    "slices": SliceRow,
    "tilt": TiltRow,
    "schemes": SchemeRow,
    "accuracy": AccuracyRow,
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
    "RemovalRow",
    "SchemeRow",
    "SectionFit",
    "SliceRow",
    "StageRunRow",
    "StationRow",
    "TiltRow",
    "columns_of",
]
