"""A workspace with every kind of file: an epoch from an inbox, earlier results, an acknowledged alarm, logs and notes."""

import hashlib
import os
import subprocess
import sys
import tomllib
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

import duckdb

from storage.archive import archive_version
from storage.catalog import rebuild_catalog
from storage.intake import append_watch_log, write_intake, write_preview, write_run_note
from storage.records import TABLES
from storage.tables import SERIES_TABLES
from storage.workspace import Workspace
from tasks.settings.intake import Intake, intake_text
from tests.faults.sites import SECOND, Site
from tests.flows.calls import ROOT, Called
from tests.flows.campaigns import STRUCTURE


def command(site: Site, *words: object, server: Mapping[str, str] | None = None) -> Called:
    """Call the command line on a site in a process of its own, with no workflow server but its own or that one."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PREFECT_")}
    environment |= {"PYTHONPATH": str(ROOT), "TILTWATCH_KEEP_SERVER_S": "0", "OMP_NUM_THREADS": "1"}
    environment |= server or {}
    name, *rest = words
    asked = [sys.executable, "-m", "flows.cli", name, site.file, *rest, "--workspace", site.workspace]
    done = subprocess.run(
        [str(word) for word in asked],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env=environment,
        timeout=300,
        check=False,
    )
    return Called(done.returncode, done.stdout, done.stderr)


def fill_up(site: Site) -> None:
    """Make a site of two published epochs hold every kind of file."""
    text = site.text()
    at = text.rindex("[[epochs]]")
    (table,) = tomllib.loads(text[at:])["epochs"]
    site.file.write_text(text[:at], encoding="utf-8")
    place = Workspace(site.workspace)
    intake = Intake(
        epoch=SECOND,
        time=table["time"],
        first_arrival=datetime(2025, 4, 14, 9, tzinfo=UTC),
        complete="marker",
        stations=table["stations"],
    )
    write_intake(place, STRUCTURE, SECOND, intake_text(intake))
    write_run_note(place, STRUCTURE, SECOND, {"exit_code": 0})
    write_preview(place, STRUCTURE, SECOND, {"stations": 5})
    append_watch_log(place, STRUCTURE, '{"event": "started"}')
    archive_version(place, STRUCTURE, "kept", ["2025-01", SECOND], "for the test")
    assert command(site, "run").code == 0
    alarm = duckdb_rows(site.workspace, "select alarm from alarm_events order by event")[0][0]
    done = command(site, "acknowledge", alarm, "--name", "a person", "--note", "seen")
    assert done.code == 0, done.err
    rebuild_catalog(place)


def duckdb_rows(workspace: Path, sql: str) -> list[tuple]:  # type: ignore[type-arg]
    """Rows of a query of the catalog."""
    with duckdb.connect(str(workspace / "catalog.duckdb"), read_only=True) as catalog:
        catalog.execute("SET TimeZone = 'UTC'")
        return catalog.execute(sql).fetchall()


def shown(workspace: Path, runs: frozenset[str]) -> Mapping[str, object]:
    """All that the catalog shows, row by row: views with types and comments, but for what later runs add.

    Which run published an epoch does not count: one that was made again is by another run.
    """
    with duckdb.connect(str(workspace / "catalog.duckdb"), read_only=True) as catalog:
        catalog.execute("SET TimeZone = 'UTC'")
        form = catalog.execute(
            "select table_name, column_name, data_type, comment from duckdb_columns() "
            "where schema_name = 'main' and not internal order by all"
        ).fetchall()
        content: dict[str, object] = {"form": form}
        for view in sorted({row[0] for row in form}):
            columns = [row[1] for row in form if row[0] == view]
            kept = ", ".join(name for name in columns if view == "runs" or not _tells_run(name))
            sql = f"select {kept} from main.{view} order by all"  # noqa: S608 - names of our own
            rows = catalog.execute(sql).fetchall()
            if view == "runs":
                at = kept.split(", ").index("run")
                rows = [row for row in rows if row[at] in runs]
            content[view] = rows
    return content


def _tells_run(column: str) -> bool:
    """Whether a column says which run it was, and under which settings as a whole."""
    return column == "campaign_digest" or "run" in column.split("_")


def kept_files(workspace: Path) -> dict[str, str]:
    """Digest of every file of a result that the next run must leave as it is, or make as it was.

    Two kinds of table say which run published an epoch; the catalog is asked for the rest of them.
    """
    folders = (
        "artifacts",
        "intake",
        "versions",
        *(f"tables/{table}" for table in TABLES if table not in ("epochs", *SERIES_TABLES)),
    )
    return {
        path.relative_to(workspace).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for folder in folders
        for path in sorted((workspace / folder).rglob("*"))
        if path.is_file() and path.name != "verified.txt" and path.suffix not in (".bad", ".tmp")
    }


def runs_in_ledger(workspace: Path) -> frozenset[str]:
    """Ids of the runs whose ledger lies there."""
    return frozenset(path.stem for path in (workspace / "tables" / "runs").glob("*/*.parquet"))
