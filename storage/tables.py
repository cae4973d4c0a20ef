"""Where the tables lie: tables/<table>/<structure>/<epoch>.parquet, and runs by run."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from storage.ids import check_id
from storage.records import TABLES
from storage.workspace import Workspace

RUNS: Final = "runs"
EPOCH_TABLES: Final = tuple(name for name in TABLES if name != RUNS)
"""The tables that are published together, one file an epoch."""


@dataclass(frozen=True, slots=True, order=True)
class EpochKey:
    """An epoch of a structure."""

    structure: str
    epoch: str

    def __str__(self) -> str:
        return f"{self.structure}/{self.epoch}"


def table_path(ws: Workspace, table: str, structure: str, part: str) -> Path:
    """Parquet file of a table for a structure and an epoch (of ``runs``: a run).

    Raises
    ------
    InputError
        If an id cannot be a file name.
    """
    what = "a run" if table == RUNS else "an epoch"
    folder = ws.tables / table / check_id(structure, "a structure")
    return folder / f"{check_id(part, what)}.parquet"


def files_of(ws: Workspace, table: str) -> list[Path]:
    """All Parquet files of a table, in the order of structure and epoch."""
    return sorted((ws.tables / table).glob("*/*.parquet"))


def key_of(path: Path) -> EpochKey:
    """Structure and epoch (of ``runs``: run) of a file of ``files_of``."""
    return EpochKey(path.parent.name, path.name.removesuffix(".parquet"))


def epochs_on_disk(ws: Workspace) -> list[EpochKey]:
    """Every epoch of which any table has a file."""
    return sorted({key_of(path) for table in EPOCH_TABLES for path in files_of(ws, table)})
