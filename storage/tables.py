"""Where the tables lie: tables/<table>/<structure>/<epoch>.parquet, and others by run, by event or by structure alone."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.ids import check_id
from storage.records import TABLES
from storage.workspace import Workspace

RUNS: Final = "runs"
ALARM_EVENTS: Final = "alarm_events"

LEDGERS: Final = {RUNS: "run", ALARM_EVENTS: "event"}
"""The tables that are only ever added to, one file a run or event, and the column that names it."""

SERIES_TABLES: Final = ("change_tests", "trends", "control_chart")
"""The tables that follow from all epochs of a structure, one file a structure: made anew, not measured."""

SERIES: Final = "series"
"""Name of that file."""

EPOCH_TABLES: Final = tuple(name for name in TABLES if name not in LEDGERS and name not in SERIES_TABLES)
"""The tables that are published together, one file an epoch."""


@dataclass(frozen=True, slots=True, order=True)
class EpochKey:
    """An epoch of a structure."""

    structure: str
    epoch: str

    def __str__(self) -> str:
        return f"{self.structure}/{self.epoch}"


def table_path(ws: Workspace, table: str, structure: str, part: str) -> Path:
    """Parquet file of a table for a structure and an epoch (of a ledger: a run or event; else ``SERIES``).

    Raises
    ------
    InputError
        If an id cannot be a file name.
    """
    what = f"a {LEDGERS.get(table, 'part')}" if table not in EPOCH_TABLES else "an epoch"
    folder = ws.tables / table / check_id(structure, "a structure")
    return folder / f"{check_id(part, what)}.parquet"


def part_column(table: str) -> str | None:
    """Column that names the part of a structure that a file of a table holds; None where it holds all of it."""
    return None if table in SERIES_TABLES else LEDGERS.get(table, "epoch")


def files_of(ws: Workspace, table: str) -> list[Path]:
    """All Parquet files of a table, in the order of structure and epoch."""
    return sorted((ws.tables / table).glob("*/*.parquet"))


def key_of(path: Path) -> EpochKey:
    """Structure and epoch (of a ledger: run or event) of a file of ``files_of``."""
    return EpochKey(path.parent.name, path.name.removesuffix(".parquet"))


def epochs_on_disk(ws: Workspace) -> list[EpochKey]:
    """Every epoch of which any table has a file."""
    return sorted({key_of(path) for table in EPOCH_TABLES for path in files_of(ws, table)})
