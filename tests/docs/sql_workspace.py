"""A made-up workspace in which every query of docs/sql.md has something to find: two structures, three epochs, an alarm."""

from dataclasses import fields, replace
from pathlib import Path

from storage.alarm_log import append_alarm_event
from storage.catalog import rebuild_catalog
from storage.digests import text_sha256
from storage.ledger import append_run, store_settings
from storage.publish import publish_epoch
from storage.series import publish_series
from storage.workspace import Workspace, open_workspace
from tests.flows.stored_series import trend_row
from tests.storage.campaign import (
    SETTINGS,
    STRUCTURE,
    alarm_event_row,
    epoch_tables,
    scheme_comparison_row,
    stage_run_row,
)


def sql_workspace(folder: Path) -> Workspace:
    """Make it as ``tiltwatch-data`` in a folder."""
    ws = open_workspace(folder / "tiltwatch-data")
    store_settings(ws, text_sha256(SETTINGS), SETTINGS)
    for structure in (STRUCTURE, "tower-02"):
        for number in range(3):
            publish_epoch(ws, structure, f"e{number}", _tables(structure, number))
        rows = [
            replace(stage_run_row(f"run-{structure}", f"e{number}"), structure=structure)
            for number in range(3)
        ]
        append_run(ws, f"run-{structure}", structure, rows)
        publish_series(ws, structure, {"trends": [replace(trend_row("e2"), structure=structure)]})
    append_alarm_event(ws, alarm_event_row("20250101T000000Z-a"))
    rebuild_catalog(ws)
    return ws


def _tables(structure: str, number: int) -> dict[str, list[object]]:
    tables = epoch_tables(f"e{number}", number, (0.007 + 1e-4 * number, -0.0057))
    tables["scheme_comparison"] = [replace(scheme_comparison_row(f"e{number}"), against="A/paper")]
    return {name: [_of(structure, row) for row in rows] for name, rows in tables.items()}


def _of(structure: str, row: object) -> object:
    return replace(row, structure=structure) if "structure" in {field.name for field in fields(row)} else row  # type: ignore[arg-type, type-var]
