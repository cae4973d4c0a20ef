"""What a workspace holds, without what differs between two undisturbed runs; and what must not be left in one."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import duckdb
from filelock import FileLock, Timeout

from storage.parquet import read_rows
from storage.places import store_of
from storage.records import TABLES, ChangeTestRow, EpochRow
from storage.run_record import read_record, runs_on_record
from storage.store import Store
from storage.tables import ALARM_EVENTS, EPOCH_TABLES, SERIES_TABLES, files_of
from storage.verify import verify_workspace_deeply
from storage.versions import archived_epochs
from storage.workspace import Workspace

EXEMPT: Final = {"run", "reference_run", "event", "happened_at"}
"""Columns that name a run or tell when something was done, and so differ between two undisturbed runs.

That ``run`` and ``reference_run`` of a comparison name the runs that made the two epochs is looked at by ``left_behind``.

``event`` is the id of an alarm event, which holds its time. Of the ledger (table runs) nothing is compared: it tells what
each run did and how long it took. All other columns of all other tables must be the same."""

EPOCHS: Final = "epochs"
CHANGES: Final = "change_tests"

Rows = Mapping[str, Sequence[str]]
"""Table to its rows as text, sorted."""


RESULTS: Final = ("epochs", "series", "alarms", "artifacts", "versions")
"""Parts of the content."""


@dataclass(frozen=True, slots=True)
class Content:
    """All results of a workspace."""

    epochs: Mapping[str, Rows]
    """Epoch to the rows of all tables of epochs."""
    series: Rows
    alarms: Sequence[str]
    artifacts: Sequence[str]
    versions: Sequence[str]
    """Earlier results that were kept: each once, with its rows."""


def content_of(ws: Workspace) -> Content:
    """Read the results from the tables."""
    epochs: dict[str, dict[str, Sequence[str]]] = {}
    for table in EPOCH_TABLES:
        for path in files_of(ws, table):
            epochs.setdefault(path.stem, {})[table] = _rows(path, table)
    series = {table: _all_rows(ws, table) for table in SERIES_TABLES}
    store: Store = store_of(ws)
    return Content(
        epochs, series, _all_rows(ws, ALARM_EVENTS), sorted(store.names("artifacts")), _versions(ws)
    )


def _versions(ws: Workspace) -> list[str]:
    kept = []
    for folder in archived_epochs(ws):
        tables = {path.stem: _rows(path, path.stem) for path in sorted(folder.glob("*.parquet"))}
        kept.append(f"{folder.name}: {tables}")
    return sorted(kept)


def shown_epochs(ws: Workspace) -> dict[str, Rows]:
    """What the catalog shows of every epoch of which it shows anything, read as anybody would; nothing without one."""
    if not ws.catalog.exists():
        return {}
    shown: dict[str, dict[str, Sequence[str]]] = {}
    with duckdb.connect(str(ws.catalog), read_only=True) as catalog:
        catalog.execute("SET TimeZone = 'UTC'")
        for table in EPOCH_TABLES:
            names = [one.name for one in fields(TABLES[table])]
            found = catalog.execute(f"SELECT {', '.join(names)} FROM data.{table}").fetchall()  # noqa: S608
            for values in found:
                row = dict(zip(names, values, strict=True))
                shown.setdefault(row["epoch"], {}).setdefault(table, [])
                shown[row["epoch"]][table] = [*shown[row["epoch"]][table], _text(row)]
    return {
        epoch: {table: sorted(tables.get(table, [])) for table in EPOCH_TABLES}
        for epoch, tables in shown.items()
    }


def left_behind(ws: Workspace) -> list[str]:
    """What a killed run left in a workspace that no one uses; empty where all is well."""
    at = [path.relative_to(ws.root).as_posix() for path in ws.root.rglob("*")]
    found = [f"temporary file {path}" for path in at if path.endswith(".tmp") or ".tmp/" in path]
    found += [f"in tmp/: {path}" for path in at if path.startswith("tmp/")]
    found += [f"server's record {path}" for path in at if re.search(r"/server\.[0-9a-f]{16}$", path)]
    found += [f"journal {path}" for path in at if path == ws.journal.name]
    found += [
        f"write-ahead log {path}" for path in at if path.startswith("catalog") and path.endswith(".wal")
    ]
    for run in runs_on_record(ws):
        record = read_record(ws, run)
        if record is None or record.ended_at is None:
            found.append(f"record of a dead run {run}")
    found += _strange_runs(ws)
    found += [f"lock held: {path}" for path in at if path.endswith(".lock") and _is_held(ws.root / path)]
    faults = verify_workspace_deeply(ws).faults
    return found + [f"verify --deep: {fault.where}: {fault.what}" for fault in faults]


def _strange_runs(ws: Workspace) -> list[str]:
    """Comparisons of epochs that are not the published ones."""
    made_by = {
        row.epoch: row.run for path in files_of(ws, EPOCHS) for row in read_rows(path, EPOCHS, EpochRow)
    }
    tests = [row for path in files_of(ws, CHANGES) for row in read_rows(path, CHANGES, ChangeTestRow)]
    return [
        f"a comparison of {row.epoch} with {row.reference_epoch} is of other results than the published ones"
        for row in tests
        if (row.run, row.reference_run) != (made_by.get(row.epoch), made_by.get(row.reference_epoch))
    ]


def _is_held(path: Path) -> bool:
    try:
        with FileLock(path).acquire(timeout=0):
            return False
    except Timeout:
        return True


def _all_rows(ws: Workspace, table: str) -> list[str]:
    return sorted(row for path in files_of(ws, table) for row in _rows(path, table))


def _rows(path: Path, table: str) -> list[str]:
    rows: list[object] = read_rows(path, table, TABLES[table])
    return sorted(_text({one.name: getattr(row, one.name) for one in fields(TABLES[table])}) for row in rows)


def _text(row: Mapping[str, object]) -> str:
    told = {name: value for name, value in row.items() if name not in EXEMPT}
    return repr({name: _plain(value) for name, value in told.items()})


def _plain(value: object) -> object:
    """A value in one spelling, whoever read it: times in UTC."""
    return value.astimezone(UTC).isoformat() if isinstance(value, datetime) else value
