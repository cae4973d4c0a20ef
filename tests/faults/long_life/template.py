"""Rows of one real epoch, and the many epochs that are made of them: 14 schemes and methods of some 100 slices."""

import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime, timedelta
from itertools import product
from pathlib import Path
from typing import Any, Final

import numpy as np

from storage.parquet import read_rows
from storage.records import TABLES, StageRunRow
from storage.tables import EPOCH_TABLES, RUNS, table_path
from storage.workspace import Workspace
from tests.flows.calls import ROOT
from tests.flows.campaigns import STRUCTURE, small_campaign

AXES: Final = (*product("ABCDEF", ("paper", "robust")), ("G", "robust"), ("S", "surface"))
WITH_SLICES: Final = {"paper": ("A", "paper"), "robust": ("A", "robust"), "surface": ("A", "robust")}
"""Scheme and method of the real epoch that has the most slices, by method: it lends its rows to all others."""

FIRST: Final = "2025-01"
START: Final = datetime(2030, 1, 7, 6, tzinfo=UTC)
APART: Final = timedelta(days=7)

Rows = Mapping[str, Sequence[Any]]


@dataclass(frozen=True)
class Template:
    """What a real run stored of a real epoch."""

    campaign_file: Path
    tables: Rows
    stages: Sequence[StageRunRow]


def processed_template(folder: Path) -> Template:
    """Simulate two epochs and process the first by the command line."""
    file = small_campaign(folder, epochs=2, stations=5)
    command = [sys.executable, "-m", "flows.cli", "-q", "run", str(file), "--epoch", FIRST]
    command += ["--workspace", str(folder / "ws")]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    ws = Workspace(folder / "ws")
    (run,) = (path.stem for path in (ws.tables / RUNS / STRUCTURE).glob("*.parquet"))
    tables: dict[str, list[Any]] = {
        table: list(read_rows(table_path(ws, table, STRUCTURE, FIRST), table, TABLES[table]))
        for table in EPOCH_TABLES
    }
    stages = read_rows(table_path(ws, RUNS, STRUCTURE, run), RUNS, StageRunRow)
    return Template(file, {table: _widened(rows) for table, rows in tables.items()}, stages)


def epoch_name(number: int) -> str:
    """Id of an epoch; sorts by time."""
    return f"e{number:05d}"


def epoch_time(number: int) -> datetime:
    """When it was measured: a week after the one before."""
    return START + number * APART


def rows_of_epoch(template: Template, number: int, run: str, digest: str, *, version: int = 0) -> Rows:
    """The rows of an epoch: those of the template, moved by noise of their own size.

    Parameters
    ----------
    version
        Another one gives other noise: results that replace those before.
    """
    rng = np.random.default_rng([number, version])
    named = {table: [_renamed(row, number) for row in rows] for table, rows in template.tables.items()}
    (epoch,) = named["epochs"]
    noise = dict(zip(AXES, rng.normal(size=(len(AXES), 2)), strict=True))
    return {
        **named,
        "epochs": [replace(epoch, run=run, campaign_digest=digest, is_reference=number == 0)],
        "tilt": [_leaning(row, noise[row.scheme, row.method]) for row in named["tilt"]],
        "axis_parameters": [_moved(row, noise[row.scheme, row.method]) for row in named["axis_parameters"]],
        "slices": [_scattered(row, rng) for row in named["slices"]],
    }


def stages_of_run(template: Template, number: int, run: str) -> list[StageRunRow]:
    """What a run of that epoch puts into the ledger."""
    return [replace(row, run=run, epoch=epoch_name(number)) for row in template.stages]


def _widened(rows: Sequence[Any]) -> list[Any]:
    """Give all schemes and methods as many rows as the one with the most slices has."""
    if not rows or not hasattr(rows[0], "scheme") or not hasattr(rows[0], "method"):
        return list(rows)
    own = {way: [row for row in rows if (row.scheme, row.method) == way] for way in WITH_SLICES.values()}
    return [
        replace(row, scheme=scheme, method=method)
        for scheme, method in AXES
        for row in own[WITH_SLICES[method]]
    ]


def _renamed(row: Any, number: int) -> Any:
    names = {field.name for field in fields(row)}
    time = {"epoch_time": epoch_time(number)} if "epoch_time" in names else {}
    return replace(row, epoch=epoch_name(number), **time)


def _leaning(row: Any, noise: Any) -> Any:
    east = row.lean_east + noise[0] * float(np.sqrt(row.lean_cov_ee))
    north = row.lean_north + noise[1] * float(np.sqrt(row.lean_cov_nn))
    size = float(np.hypot(east, north))
    return replace(
        row,
        lean_east=float(east),
        lean_north=float(north),
        tilt_deg=float(np.degrees(np.arctan(size))),
        azimuth_deg=float(np.degrees(np.arctan2(east, north)) % 360.0),
        deviation_m=row.height_m * size,
    )


def _moved(row: Any, noise: Any) -> Any:
    part = {"lean_east": 0, "lean_north": 1}.get(row.parameter)
    if part is None or row.sigma is None:
        return row
    return replace(row, value=float(row.value + noise[part] * row.sigma))


def _scattered(row: Any, rng: np.random.Generator) -> Any:
    if row.center_east_m is None or row.sigma_center_m is None:
        return row
    east, north = rng.normal(scale=row.sigma_center_m, size=2)
    return replace(
        row, center_east_m=row.center_east_m + float(east), center_north_m=row.center_north_m + float(north)
    )
