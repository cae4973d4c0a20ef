"""When the crowd has gone: what was reported done is on record, nothing is left behind, a lonely run finds the same."""

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import duckdb

from storage.atomic import TEMP_SUFFIX
from storage.parquet import read_rows
from storage.records import TABLES
from storage.tables import EPOCH_TABLES, RUNS, SERIES_TABLES, table_path
from storage.workspace import Workspace
from tests.faults.crowding.crowd import Crowd
from tests.faults.crowding.long_lived import left_behind
from tests.faults.crowding.site import Site
from tests.flows.campaigns import STRUCTURE

SERVER_S: Final = 60.0
"""So long a workflow server may stay that is kept for 15 s after its last use."""

OF_THE_RUN: Final = {"run": "", "reference_run": "", "campaign_digest": "", "code_version": ""}
"""What tells who made a row; two runs differ in it."""

Shown = dict[str, list[str]]


def judge(crowd: Crowd, shown: Shown) -> None:
    """Put everything that is wrong after the crowd into its findings."""
    site = crowd.site
    crowd.call("run", site.file, "--json")
    _left(crowd)
    crowd.call("verify", site.file, "--deep", "--json")
    with duckdb.connect(str(site.workspace / "catalog.duckdb"), read_only=True) as catalog:
        crowd.findings += [*_lost_deeds(crowd, catalog), *_lost_runs(crowd), *_lost_results(shown, catalog)]
        crowd.calls["versions"] = _number(catalog, "SELECT count(*) FROM versions")
        crowd.calls["epochs"] = _number(catalog, "SELECT count(*) FROM epochs")
        crowd.calls["alarm events"] = _number(catalog, "SELECT count(*) FROM alarm_events")
    _compare(crowd, site.lonely(site.folder / "lonely"))


def _left(crowd: Crowd) -> None:
    """Processes that stay, temps, and records of runs under way."""
    end = time.monotonic() + SERVER_S
    while (left := left_behind(crowd.site.folder)) and time.monotonic() < end:
        time.sleep(1.0)
    crowd.findings += [f"a process is left: {line}" for line in left]
    ws = Workspace(crowd.site.workspace)
    temps = [*ws.root.rglob(f"*{TEMP_SUFFIX}"), *ws.tmp.rglob("*"), *crowd.site.inbox.rglob("*")]
    crowd.findings += [
        f"left behind: {path}" for path in temps if path.is_file() and not path.name.startswith(".tiltwatch.")
    ]


def _lost_deeds(crowd: Crowd, catalog: duckdb.DuckDBPyConnection) -> Iterator[str]:
    known = catalog.execute(
        "SELECT alarm, action, note FROM alarm_events WHERE person IS NOT NULL"
    ).fetchall()
    for deed in crowd.deeds:
        if known.count(deed) != 1:
            yield f"deed {deed} is {known.count(deed)} times on record"
    if len(known) != len(crowd.deeds):
        yield f"{len(known)} deeds are on record, {len(crowd.deeds)} were reported done"


def _lost_runs(crowd: Crowd) -> Iterator[str]:
    folder = Workspace(crowd.site.workspace).tables / RUNS / STRUCTURE
    stored = {path.name.removesuffix(".parquet") for path in folder.iterdir()}
    yield from (f"run {run} is not in the ledger" for run in crowd.runs if run not in stored)
    if len(set(crowd.runs)) != len(crowd.runs):
        yield "two runs had one id"


def _lost_results(shown: Shown, catalog: duckdb.DuckDBPyConnection) -> Iterator[str]:
    kept = set(
        catalog.execute("SELECT epoch, run FROM epochs UNION SELECT epoch, run FROM versions").fetchall()
    )
    for epoch, runs in shown.items():
        yield from (
            f"{epoch} of run {run} was shown and is kept nowhere" for run in runs if (epoch, run) not in kept
        )


def _compare(crowd: Crowd, alone: Site) -> None:
    """Run the final campaign in a workspace of its own, and compare all tables."""
    lonely = Crowd(alone)
    lonely.call("run", alone.file, "--json")
    crowd.findings += [f"lonely: {line}" for line in lonely.findings]
    parts = sorted(_parts(crowd.site.workspace))
    if parts != sorted(_parts(alone.workspace)):
        crowd.find(f"the crowd has {parts}, the lonely run {sorted(_parts(alone.workspace))}")
        return
    for table, part in parts:
        if _rows(crowd.site.workspace, table, part) != _rows(alone.workspace, table, part):
            crowd.find(f"{table} of {part} differs from that of a lonely run")
    crowd.calls["tables compared"] = len(parts)


def _parts(workspace: Path) -> Iterator[tuple[str, str]]:
    for table in (*EPOCH_TABLES, *SERIES_TABLES):
        for path in (workspace / "tables" / table / STRUCTURE).iterdir():
            yield table, path.name.removesuffix(".parquet")


def _rows(workspace: Path, table: str, part: str) -> list[Any]:
    rows: list[Any] = read_rows(
        table_path(Workspace(workspace), table, STRUCTURE, part), table, TABLES[table]
    )
    return [_without_run(row) for row in rows]


def _without_run(row: Any) -> str:
    return repr(replace(row, **{name: value for name, value in OF_THE_RUN.items() if hasattr(row, name)}))


def _number(catalog: duckdb.DuckDBPyConnection, sql: str) -> int:
    ((number,),) = catalog.execute(sql).fetchall()
    return int(number)
